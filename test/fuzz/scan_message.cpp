// Scans of the network, as safety_area_merger reads them: one comes out as long as it came in, and no
// valid range grows.
#include <fuzzer/FuzzedDataProvider.h>
#include <sensor_msgs/LaserScan.h>

#include <cstdlib>
#include <cstring>
#include <vector>

#include "safe_passage/ros/safety_area_messages.h"
#include "safe_passage/safety_area/scan_merger.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  namespace areas = safe_passage::safety_area;
  FuzzedDataProvider from(data, size);
  sensor_msgs::LaserScan scan;
  scan.angle_min = from.ConsumeFloatingPoint<float>();
  scan.angle_max = from.ConsumeFloatingPoint<float>();
  scan.angle_increment = from.ConsumeFloatingPoint<float>();
  scan.range_min = from.ConsumeFloatingPoint<float>();
  scan.range_max = from.ConsumeFloatingPoint<float>();
  const auto number = [&from] {
    const auto bits = from.ConsumeIntegral<std::uint32_t>();
    float value;
    std::memcpy(&value, &bits, sizeof value);
    return value;
  };
  if (from.ConsumeBool()) scan.angle_min = -1.5F, scan.angle_increment = number();
  if (from.ConsumeBool()) scan.range_min = 0.1F, scan.range_max = 20.0F;
  const bool intensities = from.ConsumeBool();
  while (from.remaining_bytes() >= 4) {
    scan.ranges.push_back(number());
    if (intensities) scan.intensities.push_back(1.0F);
  }
  const std::vector<areas::Circle> circles{{2.0, 0.5, 1.2}, {0.3, -0.2, 1.2}, {-1.0, 3.0, 0.6}};
  const areas::Outline robot{{0.1, 0.3}, {-0.7, 0.3}, {-0.7, -0.3}, {0.1, -0.3}};
  for (const areas::Outline& outline : {areas::Outline{}, robot}) {
    const auto merged = areas::merge(safe_passage::to_scan(scan), circles, {}, outline);
    if (merged.ranges.size() != scan.ranges.size()) std::abort();
    if (merged.intensities.size() != scan.intensities.size()) std::abort();
    for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
      const float real = scan.ranges[i];
      const bool valid = real >= scan.range_min && real <= scan.range_max && real > 0.0F;
      if (valid && merged.ranges[i] > real) std::abort();
    }
  }
  return 0;
}
