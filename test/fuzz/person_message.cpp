// Persons of the network, as safety_area_merger remembers them: whatever is told of others, who stands
// before the robot has a safety area, and no valid range grows.
#include <fuzzer/FuzzedDataProvider.h>

#include <cmath>
#include <cstdlib>
#include <cstring>

#include "safe_passage/ros/safety_area_messages.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  namespace areas = safe_passage::safety_area;
  constexpr double kNow = 100.0;  // [s]; the node refuses messages that are not of about now
  const Eigen::Vector3d standing(2.0, 0.0, 0.0);
  FuzzedDataProvider from(data, size);
  areas::PipelineParameters parameters;
  parameters.area.velocity_stretch = from.ConsumeBool() ? 0.7 : 0.0;
  parameters.area.growth_speed = from.ConsumeBool() ? 0.5 : 0.0;
  parameters.memory.laser_hold_time = from.ConsumeBool() ? 10.0 : 0.0;
  const double late = from.ConsumeFloatingPointInRange<double>(0.0, 0.9);

  safe_passage::PersonArray message;
  message.header.stamp.fromSec(kNow);
  message.persons.resize(1);
  message.persons[0].position.x = standing.x();
  const auto number = [&from] {
    const auto bits = from.ConsumeIntegral<std::uint64_t>();
    double value;
    std::memcpy(&value, &bits, sizeof value);
    return value;
  };
  while (from.remaining_bytes() >= 32) {
    safe_passage::Person person;
    person.id = from.ConsumeIntegral<std::uint32_t>();
    person.position.x = number(), person.position.y = number();
    person.velocity.x = number(), person.velocity.y = number();
    message.persons.push_back(person);
  }

  areas::Pipeline pipeline(parameters);
  pipeline.remember(safe_passage::to_persons(message, Eigen::Isometry3d::Identity()));
  areas::Scan scan;
  scan.angle_min = -1.5F, scan.angle_max = 1.5F, scan.angle_increment = 0.01F;
  scan.range_min = 0.1F, scan.range_max = 20.0F;
  scan.ranges.assign(301, 8.0F);
  const auto result = pipeline.merge(scan, kNow + late, areas::LaserPose{});
  bool has_area = false;
  for (const areas::Circle& area : result.areas)
    has_area |= std::hypot(area.x - standing.x(), area.y - standing.y()) < 1e-6;
  if (!has_area) std::abort();
  for (const float range : result.scan.ranges)
    if (!(range <= 8.0F)) std::abort();
  if (!(result.scan.ranges[150] <= 0.81F)) std::abort();  // 2 m less the area's radius
  return 0;
}
