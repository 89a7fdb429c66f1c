#include "safe_passage/safety_area/pipeline.h"

#include <algorithm>
#include <cmath>

namespace safe_passage::safety_area {

std::vector<Circle> safety_areas(const std::vector<Person>& persons, double time,
                                 const LaserPose& pose, const AreaParameters& params) {
  std::vector<Circle> areas;
  areas.reserve(persons.size());
  for (const Person& person : persons) {
    const Eigen::Vector3d p_laser = pose.T_laser_fixed * person.position;
    const double distance = std::hypot(p_laser.x(), p_laser.y());
    const double robot_motion =
        std::min(pose.age * (params.max_robot_speed + distance * params.max_robot_turn_rate),
                 params.max_growth);
    const double person_motion = params.growth_speed * std::max(0.0, time - person.stamp);
    areas.push_back({p_laser.x(), p_laser.y(), params.radius + person_motion + robot_motion});
  }
  return areas;
}

Pipeline::Result Pipeline::merge(const Scan& scan, double time,
                                 const std::optional<LaserPose>& pose) const {
  Result result;
  result.persons = memory_.at(time);
  if (pose) result.areas = safety_areas(result.persons, time, *pose, params_.area);
  result.scan = safety_area::merge(scan, result.areas, params_.merge);
  return result;
}

}  // namespace safe_passage::safety_area
