// persons -> safety areas -> merged scan (paper 002, algorithm 1).
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "safe_passage/safety_area/person_memory.h"
#include "safe_passage/safety_area/scan_merger.h"

namespace safe_passage::safety_area {

struct AreaParameters {
  double radius = 1.2;            // [m] proxemics, paper section 2.3
  double growth_speed = 0.0;      // [m/s] a person may have moved since detected, beyond velocity
  double velocity_stretch = 0.0;  // [s] of the person's way ahead that the area covers too
  double max_robot_speed = 1.0;   // [m/s] what the robot may have done since its last known pose
  double max_robot_turn_rate = 1.0;  // [rad/s] the same
  double max_growth = 1.0;           // [m] most that an old robot pose adds to a radius
};

// Where the laser was. It need not be known for the very moment of the scan: `age` widens the
// areas.
struct LaserPose {
  Eigen::Isometry3d T_laser_fixed = Eigen::Isometry3d::Identity();
  double age = 0.0;  // [s] of the pose at the scan's time
};

struct PipelineParameters {
  MemoryParameters memory;
  AreaParameters area;
  MergeParameters merge;
};

// Circles in the laser's plane, wide enough to cover each person's area wherever the robot may have
// driven within the pose's age: by then a point at distance d has moved by speed + d * turn rate.
// With velocity_stretch more of them, without a body, follow along the way of a person who moves.
std::vector<Circle> safety_areas(const std::vector<Person>& persons, double time,
                                 const LaserPose& pose, const AreaParameters& params);

class Pipeline {
 public:
  struct Result {
    MergedScan scan;
    std::vector<Person> persons;  // fixed frame
    std::vector<Circle> areas;    // laser frame, before the inside policy
  };

  explicit Pipeline(const PipelineParameters& params = {})
      : params_(params), memory_(params.memory) {}

  // Other parameters from now on; persons stay.
  void tune(const PipelineParameters& params) {
    params_ = params;
    memory_.tune(params.memory);
  }

  PersonMemory::Update remember(const std::vector<Person>& persons) {
    return memory_.update(persons);
  }

  // `time` [s] of the scan, which also keeps persons that no camera sees any more (see memory). No
  // pose: the scan comes back without areas. `robot`: see scan_merger.h.
  Result merge(const Scan& scan, double time, const std::optional<LaserPose>& pose,
               const Outline& robot = {});

  void clear() { memory_.clear(); }

 private:
  PipelineParameters params_;
  PersonMemory memory_;
};

}  // namespace safe_passage::safety_area
