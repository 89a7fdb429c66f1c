// The parameters of node safety_area_merger; config/safety_area_merger.yaml explains each of them.
#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

#include "safe_passage/ros/parameters.h"
#include "safe_passage/ros/safety_area_messages.h"
#include "safe_passage/safety_area/pipeline.h"

namespace safe_passage {

struct SafetyAreaParameters {
  safety_area::PipelineParameters pipeline;
  std::string fixed_frame = "odom";
  std::string base_frame = "base_footprint";  // of `footprint`
  std::vector<Eigen::Vector2d> footprint;     // [m] empty: the robot is where the laser is
  double tf_tolerance = 0.2;      // [s] the robot's pose may be that old before it is reported
  double future_tolerance = 0.1;  // [s] persons may be stamped that far ahead
  double input_timeout = 2.0;     // [s] an input silent for longer is reported
};

inline safety_area::InsidePolicy read_inside_policy(Parameters& from) {
  using safety_area::InsidePolicy;
  static const std::map<std::string, InsidePolicy> kPolicies = {{"shrink", InsidePolicy::kShrink},
                                                                {"body", InsidePolicy::kBody},
                                                                {"block", InsidePolicy::kBlock}};
  std::string name = "shrink";
  from.read_choice("inside_policy", name, {"shrink", "body", "block"});
  return kPolicies.at(name);
}

inline std::vector<Eigen::Vector2d> read_footprint(Parameters& from) {
  std::vector<Eigen::Vector2d> corners;
  for (const auto& [x, y] : from.read_points("footprint")) corners.emplace_back(x, y);
  if (!corners.empty() && corners.size() < 3)
    from.fail("footprint", "must have three corners or more, or none");
  return corners;
}

// May be changed while the node runs; not what it waits for.
inline const std::set<std::string> kLiveSafetyAreaParameters = {
    "radius",          "growth_speed",        "velocity_stretch",
    "max_robot_speed", "hold_time",           "laser_hold_time",
    "laser_gate",      "max_robot_turn_rate", "gate",
    "max_growth",      "max_person_speed",    "max_persons",
    "inside_policy",   "clearance",           "body_radius",
    "tf_tolerance",    "future_tolerance"};

// Throws std::runtime_error naming the parameter at fault.
inline SafetyAreaParameters read_safety_area_parameters(Parameters& from) {
  SafetyAreaParameters params;
  auto& [memory, area, merge] = params.pipeline;
  from.read("fixed_frame", params.fixed_frame);
  params.fixed_frame = tf_name(params.fixed_frame);
  if (params.fixed_frame.empty()) from.fail("fixed_frame", "is empty");

  from.read("base_frame", params.base_frame);
  params.base_frame = tf_name(params.base_frame);
  params.footprint = read_footprint(from);

  from.read("radius", area.radius, {0.05, 10.0}, "m");
  from.read("growth_speed", area.growth_speed, {0.0, 5.0}, "m/s");
  from.read("velocity_stretch", area.velocity_stretch, {0.0, 5.0}, "s");
  from.read("max_robot_speed", area.max_robot_speed, {0.0, 20.0}, "m/s");
  from.read("max_robot_turn_rate", area.max_robot_turn_rate, {0.0, 20.0}, "rad/s");
  from.read("max_growth", area.max_growth, {0.0, 10.0}, "m");

  from.read("hold_time", memory.hold_time, {0.05, 60.0}, "s");
  from.read("laser_hold_time", memory.laser_hold_time, {0.0, 600.0}, "s");
  from.read("laser_gate", memory.laser_gate, {0.05, 2.0}, "m");
  from.read("gate", memory.gate, {0.0, 5.0}, "m");
  from.read("max_person_speed", memory.max_person_speed, {0.0, 20.0}, "m/s");
  int max_persons = static_cast<int>(memory.max_persons);
  from.read("max_persons", max_persons, {1, 1000}, "persons");
  memory.max_persons = static_cast<std::size_t>(max_persons);

  merge.inside_policy = read_inside_policy(from);
  from.read("clearance", merge.clearance, {0.0, 5.0}, "m");
  from.read("body_radius", merge.body_radius, {0.05, 1.0}, "m");
  double intensity = merge.intensity;
  from.read("intensity", intensity, {0.0, 1e9}, "(the sensor's unit)");
  merge.intensity = static_cast<float>(intensity);

  from.read("tf_tolerance", params.tf_tolerance, {0.0, memory.hold_time}, "s (up to hold_time)");
  from.read("future_tolerance", params.future_tolerance, {0.0, 10.0}, "s");
  from.read("input_timeout", params.input_timeout, {0.1, 3600.0}, "s");
  from.refuse_unknown();
  return params;
}

}  // namespace safe_passage
