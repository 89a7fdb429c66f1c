// Clouds of the network, as person_detector reads them: what fault_of() lets pass must be read.
// Made field by field: of bytes roscpp itself would set aside what a length tells of.
#include <fuzzer/FuzzedDataProvider.h>

#include <cstdlib>

#include "safe_passage/ros/person_conversions.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  namespace detection = safe_passage::person_detection;
  FuzzedDataProvider from(data, size);
  sensor_msgs::PointCloud2 cloud;
  const auto number = [&from] {  // mostly small, so that some clouds are sound
    return from.ConsumeBool() ? from.ConsumeIntegralInRange<std::uint32_t>(0, 24)
                              : from.ConsumeIntegral<std::uint32_t>();
  };
  cloud.height = number();
  cloud.width = number();
  cloud.point_step = number();
  cloud.row_step = from.ConsumeBool() ? cloud.width * cloud.point_step : number();
  cloud.is_bigendian = from.ConsumeBool();
  const int fields = from.ConsumeIntegralInRange(0, 6);
  for (int i = 0; i < fields; ++i) {
    sensor_msgs::PointField field;
    field.name = from.PickValueInArray({"x", "y", "z", "rgb", "rgba", ""});
    field.offset = number();
    field.datatype = from.ConsumeIntegralInRange<std::uint8_t>(0, 9);
    field.count = from.ConsumeIntegralInRange<std::uint32_t>(0, 2);
    cloud.fields.push_back(field);
  }
  cloud.data = from.ConsumeRemainingBytes<std::uint8_t>();
  if (!detection::fault_of(cloud).empty()) return 0;
  const auto frame = detection::to_frame(cloud);
  if (frame.xyz.rows != static_cast<int>(cloud.width > 0 ? cloud.height : 0)) std::abort();
  if (frame.xyz.cols != static_cast<int>(cloud.width)) std::abort();
  return 0;
}
