#include "safe_passage/ros/person_conversions.h"

#include <sensor_msgs/image_encodings.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <stdexcept>

namespace safe_passage::person_detection {
namespace {

using sensor_msgs::PointField;

const PointField* find_field(const sensor_msgs::PointCloud2& cloud, const std::string& name) {
  for (const auto& field : cloud.fields)
    if (field.name == name) return &field;
  return nullptr;
}

const PointField* find_colour(const sensor_msgs::PointCloud2& cloud) {
  const PointField* rgb = find_field(cloud, "rgb");
  return rgb ? rgb : find_field(cloud, "rgba");
}

// All fields in use are four bytes long.
bool inside_point(const PointField& field, const sensor_msgs::PointCloud2& cloud) {
  return std::uint64_t{field.offset} + 4 <= cloud.point_step;
}

template <typename Sized>
std::string said_size(const Sized& message) {
  return std::to_string(message.width) + " x " + std::to_string(message.height);
}

// In 64 bits: of cv_bridge's 32, sizes that lie can wrap round to ones that fit.
std::string fault_of(const sensor_msgs::Image& image) {
  namespace encodings = sensor_msgs::image_encodings;
  try {
    const int bits = encodings::numChannels(image.encoding) * encodings::bitDepth(image.encoding);
    const bool is_empty = image.width == 0 || image.height == 0;
    if (is_empty || image.step < std::uint64_t{image.width} * static_cast<unsigned>(bits) / 8 ||
        image.data.size() != std::uint64_t{image.step} * image.height)
      return image.encoding + " image of " + std::to_string(image.data.size()) + " bytes for " +
             said_size(image) + " pixels";
  } catch (const std::runtime_error& error) {  // of an encoding nobody knows
    return error.what();
  }
  return "";
}

geometry_msgs::Point to_point(const Eigen::Vector3f& p) {
  geometry_msgs::Point point;
  point.x = p.x();
  point.y = p.y();
  point.z = p.z();
  return point;
}

struct UprightBox {
  geometry_msgs::Pose pose;  // in the camera's frame
  geometry_msgs::Vector3 size;
};

UprightBox to_box(const Candidate& candidate, const GroundFrame& frame) {
  UprightBox box;
  box.pose.position = to_point(frame.to_camera(0.5F * (candidate.low + candidate.high)));
  const Eigen::Quaternionf q(Eigen::Matrix3f(frame.R.transpose()));
  box.pose.orientation.x = q.x();
  box.pose.orientation.y = q.y();
  box.pose.orientation.z = q.z();
  box.pose.orientation.w = q.w();
  const Eigen::Vector3f size = candidate.high - candidate.low;
  box.size.x = size.x();
  box.size.y = size.y();
  box.size.z = size.z();
  return box;
}

visualization_msgs::Marker marker(const std_msgs::Header& header, const std::string& ns, int id,
                                  int type) {
  visualization_msgs::Marker marker;
  marker.header = header;
  marker.ns = ns;
  marker.id = id;
  marker.type = type;
  marker.pose.orientation.w = 1.0;
  marker.lifetime = ros::Duration(1.0);  // a detector that stops must not leave persons standing
  return marker;
}

visualization_msgs::Marker box_marker(const std_msgs::Header& header, const std::string& ns, int id,
                                      const UprightBox& box) {
  auto cube = marker(header, ns, id, visualization_msgs::Marker::CUBE);
  cube.pose = box.pose;
  cube.scale = box.size;
  return cube;
}

visualization_msgs::Marker cluster_marker(const DetectionResult& result, const GroundFrame& frame,
                                          const std_msgs::Header& header) {
  auto points = marker(header, "clusters", 0, visualization_msgs::Marker::POINTS);
  points.scale.x = points.scale.y = 0.04;
  points.color.a = 1.0F;
  for (std::size_t i = 0; i < result.clusters.size(); ++i) {
    std_msgs::ColorRGBA colour;  // neighbours in the list differ clearly
    colour.r = 0.3F + 0.2F * static_cast<float>(i % 3);
    colour.g = 0.4F + 0.2F * static_cast<float>(i / 3 % 3);
    colour.b = 1.0F;
    colour.a = 1.0F;
    for (const int p : result.clusters[i]) {
      points.points.push_back(to_point(frame.to_camera(result.points[p])));
      points.colors.push_back(colour);
    }
  }
  return points;
}

}  // namespace

std::string fault_of(const sensor_msgs::PointCloud2& cloud) {
  for (const char* name : {"x", "y", "z"}) {
    const PointField* field = find_field(cloud, name);
    if (!field || field->datatype != PointField::FLOAT32)
      return std::string("no float field ") + name;
    if (!inside_point(*field, cloud)) return "a field lies outside the point";
  }
  const PointField* colour = find_colour(cloud);
  if (!colour || !inside_point(*colour, cloud)) return "no field rgb";
  if (cloud.is_bigendian) return "big-endian data";
  if (cloud.height < 2) return "the cloud is not organised";
  // In 64 bits: sizes that lie must not wrap round to ones that fit.
  if (cloud.row_step < std::uint64_t{cloud.width} * cloud.point_step ||
      cloud.data.size() < std::uint64_t{cloud.row_step} * cloud.height)
    return "less data than its size says";
  return "";
}

std::string fault_of(const sensor_msgs::Image& depth, const sensor_msgs::Image& rgb,
                     const sensor_msgs::CameraInfo& info) {
  for (const std_msgs::Header* other : {&rgb.header, &info.header})
    if (other->frame_id != depth.header.frame_id)
      return "depth in frame " + depth.header.frame_id + ", colours or camera info in " +
             other->frame_id + ": not registered";
  if (info.width != rgb.width || info.height != rgb.height)
    return "camera info of " + said_size(info) + " pixels, colours of " + said_size(rgb);
  const std::string fault = fault_of(depth);
  return fault.empty() ? fault_of(rgb) : fault;
}

RgbdFrame to_frame(const sensor_msgs::PointCloud2& cloud) {
  RgbdFrame frame;
  const int columns = static_cast<int>(cloud.width);
  const int rows = columns > 0 ? static_cast<int>(cloud.height) : 0;  // else they cost no data
  frame.xyz.create(rows, columns, CV_32FC3);
  frame.bgr.create(rows, columns, CV_8UC3);
  const auto x = find_field(cloud, "x")->offset, y = find_field(cloud, "y")->offset,
             z = find_field(cloud, "z")->offset, rgb = find_colour(cloud)->offset;
  for (int row = 0; row < rows; ++row) {
    const auto* point = cloud.data.data() + static_cast<std::size_t>(row) * cloud.row_step;
    auto* xyz = frame.xyz.ptr<cv::Vec3f>(row);
    auto* bgr = frame.bgr.ptr<cv::Vec3b>(row);
    for (int column = 0; column < columns; ++column, point += cloud.point_step) {
      std::memcpy(&xyz[column][0], point + x, sizeof(float));
      std::memcpy(&xyz[column][1], point + y, sizeof(float));
      std::memcpy(&xyz[column][2], point + z, sizeof(float));
      std::memcpy(bgr[column].val, point + rgb, 3);  // little-endian 0xRRGGBB
    }
  }
  return frame;
}

Intrinsics to_intrinsics(const sensor_msgs::CameraInfo& info) {
  if (info.P[0] > 0.0) return {info.P[0], info.P[5], info.P[2], info.P[6]};
  return {info.K[0], info.K[4], info.K[2], info.K[5]};
}

GroundPlane to_ground_plane(const geometry_msgs::Transform& T_camera_ground) {
  const auto& q = T_camera_ground.rotation;
  const auto& t = T_camera_ground.translation;
  const Eigen::Vector3d up = Eigen::Quaterniond(q.w, q.x, q.y, q.z) * Eigen::Vector3d::UnitZ();
  return {up.cast<float>(), static_cast<float>(-up.dot(Eigen::Vector3d(t.x, t.y, t.z)))};
}

PersonArray to_message(const DetectionResult& result, Method method,
                       const std_msgs::Header& header) {
  PersonArray array;
  array.header = header;
  const GroundFrame frame(result.ground.plane);
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  for (const Detection& detection : result.detections) {
    if (!detection.accepted) continue;
    const Candidate& candidate = detection.candidate;
    Person person;
    const Eigen::Vector3f middle = 0.5F * (candidate.low + candidate.high);
    person.position = to_point(frame.to_camera({middle.x(), middle.y(), 0.0F}));
    person.velocity.x = person.velocity.y = person.velocity.z = kUnknown;
    const UprightBox box = to_box(candidate, frame);
    person.box_pose = box.pose;
    person.box_size = box.size;
    person.height = candidate.head.z();
    person.confidence = detection.confidence;
    person.method = method == Method::kYolo ? Person::METHOD_YOLO : Person::METHOD_HOG;
    person.roi.x_offset = static_cast<std::uint32_t>(std::max(0, candidate.roi.x));
    person.roi.y_offset = static_cast<std::uint32_t>(std::max(0, candidate.roi.y));
    person.roi.width =
        static_cast<std::uint32_t>(std::max(0, candidate.roi.br().x)) - person.roi.x_offset;
    person.roi.height =
        static_cast<std::uint32_t>(std::max(0, candidate.roi.br().y)) - person.roi.y_offset;
    array.persons.push_back(person);
  }
  return array;
}

visualization_msgs::MarkerArray to_markers(const DetectionResult& result,
                                           const std_msgs::Header& header) {
  visualization_msgs::MarkerArray markers;
  auto clear = marker(header, "", 0, visualization_msgs::Marker::CUBE);
  clear.action = visualization_msgs::Marker::DELETEALL;
  markers.markers.push_back(clear);
  const GroundFrame frame(result.ground.plane);
  if (!result.clusters.empty()) markers.markers.push_back(cluster_marker(result, frame, header));
  int id = 0;
  for (const Detection& detection : result.detections) {
    const UprightBox box = to_box(detection.candidate, frame);
    auto cube = box_marker(header, detection.accepted ? "persons" : "sub-clusters", id, box);
    cube.color.r = cube.color.g = detection.accepted ? 1.0F : 0.6F;
    cube.color.b = detection.accepted ? 0.0F : 0.6F;
    cube.color.a = detection.accepted ? 0.45F : 0.2F;
    markers.markers.push_back(cube);
    ++id;
    if (!detection.accepted) continue;
    auto text = marker(header, "confidence", id, visualization_msgs::Marker::TEXT_VIEW_FACING);
    text.pose.position =
        to_point(frame.to_camera(detection.candidate.head + Eigen::Vector3f(0.0F, 0.0F, 0.2F)));
    text.scale.z = 0.2;
    text.color.r = text.color.g = text.color.b = text.color.a = 1.0F;
    char label[32];
    std::snprintf(label, sizeof label, "%.2f", static_cast<double>(detection.confidence));
    text.text = label;
    markers.markers.push_back(text);
  }
  return markers;
}

}  // namespace safe_passage::person_detection
