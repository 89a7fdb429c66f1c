// Depth and colour images of the network, as person_detector reads them: what fault_of() lets pass
// is read within its bytes, or refused with a reason. cv_bridge multiplies sizes in 32 bits.
#include <cv_bridge/cv_bridge.h>
#include <fuzzer/FuzzedDataProvider.h>

#include <boost/make_shared.hpp>
#include <cstdlib>

#include "safe_passage/person_detection/frame_io.h"
#include "safe_passage/ros/person_conversions.h"

namespace {

sensor_msgs::ImagePtr make_image(FuzzedDataProvider& from, std::size_t bytes) {
  const auto number = [&from] {  // mostly small, so that some images are sound
    return from.ConsumeBool() ? from.ConsumeIntegralInRange<std::uint32_t>(0, 8)
                              : from.PickValueInArray<std::uint32_t>(
                                    {1U << 16, 1U << 28, 1U << 29, 1U << 30, 1U << 31, 0xffffffff});
  };
  auto image = boost::make_shared<sensor_msgs::Image>();
  image->height = number();
  image->width = number();
  image->encoding = from.PickValueInArray(
      {"16UC1", "32FC1", "bgr8", "rgb8", "mono8", "bayer_rggb8", "yuv422", "8UC0", "32FC9", ""});
  image->is_bigendian = from.ConsumeBool();
  image->step = from.ConsumeBool() ? number() : image->width * from.ConsumeIntegralInRange(1, 4);
  image->data = from.ConsumeBytes<std::uint8_t>(bytes);
  if (from.ConsumeBool()) image->data.resize(std::min(image->height * image->step, 1U << 16));
  return image;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  namespace detection = safe_passage::person_detection;
  FuzzedDataProvider from(data, size);
  sensor_msgs::CameraInfo info;
  info.K[0] = info.K[4] = from.ConsumeFloatingPoint<double>();
  info.K[2] = info.K[5] = from.ConsumeFloatingPoint<double>();
  const sensor_msgs::ImageConstPtr depth = make_image(from, size / 3),
                                   rgb = make_image(from, size / 3);
  info.width = rgb->width;
  info.height = rgb->height;
  if (!detection::fault_of(*depth, *rgb, info).empty()) return 0;
  try {
    const auto bgr = cv_bridge::toCvShare(rgb, "bgr8");
    const auto frame = detection::from_depth(cv_bridge::toCvShare(depth)->image, bgr->image,
                                             detection::to_intrinsics(info));
    if (frame.xyz.rows != static_cast<int>(depth->height)) std::abort();
  } catch (const std::exception& error) {  // as the node has it
    if (!*error.what()) std::abort();
  }
  return 0;
}
