// Messages that person_detector reads: what it can use, and why not.
#include <gtest/gtest.h>

#include "safe_passage/ros/person_conversions.h"

namespace safe_passage::person_detection {
namespace {

sensor_msgs::PointCloud2 make_cloud(std::uint32_t width, std::uint32_t height) {
  sensor_msgs::PointCloud2 cloud;
  cloud.width = width;
  cloud.height = height;
  cloud.point_step = 16;
  cloud.row_step = 16 * width;
  cloud.data.resize(cloud.row_step * height);
  for (const char* name : {"x", "y", "z", "rgb"}) {
    sensor_msgs::PointField field;
    field.name = name;
    field.offset = 4 * static_cast<std::uint32_t>(cloud.fields.size());
    field.datatype = sensor_msgs::PointField::FLOAT32;
    field.count = 1;
    cloud.fields.push_back(field);
  }
  return cloud;
}

sensor_msgs::Image make_image(const std::string& encoding, std::uint32_t pixel) {
  sensor_msgs::Image image;
  image.width = 4;
  image.height = 3;
  image.encoding = encoding;
  image.step = 4 * pixel;
  image.data.resize(image.step * image.height);
  return image;
}

struct Images {
  sensor_msgs::Image depth = make_image("16UC1", 2), rgb = make_image("bgr8", 3);
  sensor_msgs::CameraInfo info;

  std::string fault() {
    info.width = rgb.width;
    info.height = rgb.height;
    return fault_of(depth, rgb, info);
  }
};

TEST(Clouds, AreReadAsTheyAre) {
  const auto cloud = make_cloud(3, 2);
  EXPECT_EQ(fault_of(cloud), "");
  EXPECT_EQ(to_frame(cloud).xyz.size(), cv::Size(3, 2));
}

TEST(Clouds, WithoutColumnsAreEmpty) {
  const auto cloud = make_cloud(0, 2);
  EXPECT_EQ(fault_of(cloud), "");
  EXPECT_TRUE(to_frame(cloud).xyz.empty());
  EXPECT_TRUE(to_frame(cloud).bgr.empty());
}

TEST(Clouds, WithoutColumnsCostNoMemoryHoweverManyRowsTheyClaim) {
  auto cloud = make_cloud(0, 2);
  cloud.height = 0xffffffff;
  ASSERT_EQ(fault_of(cloud), "");
  EXPECT_TRUE(to_frame(cloud).xyz.empty());
}

TEST(Clouds, WithoutRowsAreNotOrganised) {
  EXPECT_EQ(fault_of(make_cloud(3, 0)), "the cloud is not organised");
}

TEST(Clouds, WhosePointsHaveNoBytesHaveNoFieldsInThem) {
  auto cloud = make_cloud(3, 2);
  cloud.point_step = cloud.row_step = 0;
  cloud.data.clear();
  EXPECT_EQ(fault_of(cloud), "a field lies outside the point");
}

TEST(Images, AreUsedAsTheyAre) { EXPECT_EQ(Images().fault(), ""); }

// cv_bridge's 32 bits wrap round to 0 bytes. Found by tools/test --fuzz.
TEST(Images, WhoseRowsWrapRoundAreRefused) {
  Images images;
  images.rgb.height = 1 << 16;
  images.rgb.step = 1 << 16;
  images.rgb.data.clear();
  EXPECT_EQ(images.fault(), "bgr8 image of 0 bytes for 4 x 65536 pixels");
}

TEST(Images, WhosePixelsWrapRoundAreRefused) {
  Images images;
  images.depth.encoding = "32FC1";
  images.depth.width = 1U << 30;
  EXPECT_EQ(images.fault(), "32FC1 image of 24 bytes for 1073741824 x 3 pixels");
}

TEST(Images, OfMoreOrLessBytesThanTheirSizeAreRefused) {
  for (const std::size_t bytes : {0, 23, 25}) {
    Images images;
    images.depth.data.resize(bytes);
    EXPECT_NE(images.fault().find("16UC1 image of " + std::to_string(bytes)), std::string::npos);
  }
}

TEST(Images, OfNoPixelsAreRefused) {
  for (const auto side : {&sensor_msgs::Image::width, &sensor_msgs::Image::height}) {
    Images images;
    images.depth.*side = 0;
    images.depth.data.clear();
    EXPECT_NE(images.fault().find("16UC1 image of 0 bytes"), std::string::npos);
  }
}

TEST(Images, OfAnEncodingNobodyKnowsAreRefused) {
  Images images;
  images.rgb.encoding = "???";
  EXPECT_NE(images.fault().find("???"), std::string::npos);
}

}  // namespace
}  // namespace safe_passage::person_detection

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
