#include "safe_passage/safety_area/pipeline.h"

#include <algorithm>
#include <cmath>

namespace safe_passage::safety_area {

namespace {

constexpr double kSpacing = 0.4;  // of the radius: the waist between two circles is 2 % narrower

// How many circles the way ahead takes.
int stretched(const Eigen::Vector3d& way, double radius) {
  return static_cast<int>(std::ceil(way.norm() / (kSpacing * radius)));
}

}  // namespace

std::vector<Circle> safety_areas(const std::vector<Person>& persons, double time,
                                 const LaserPose& pose, const AreaParameters& params) {
  std::vector<Circle> areas;
  areas.reserve(persons.size());
  for (const Person& person : persons) {
    const Eigen::Vector3d p_laser = pose.T_laser_fixed * person.position;
    const double distance = std::hypot(p_laser.x(), p_laser.y());
    const double robot_motion =
        std::min(params.max_growth,  // first: also of a distance beyond what a double holds
                 pose.age * (params.max_robot_speed + distance * params.max_robot_turn_rate));
    const double person_motion = params.growth_speed * std::max(0.0, time - person.stamp);
    const double radius = params.radius + person_motion + robot_motion;
    areas.push_back({p_laser.x(), p_laser.y(), radius});
    if (!person.velocity.allFinite()) continue;
    const Eigen::Vector3d way = pose.T_laser_fixed.linear() * person.velocity;
    const Eigen::Vector3d ahead = params.velocity_stretch * Eigen::Vector3d(way.x(), way.y(), 0.0);
    const int count = stretched(ahead, radius);
    for (int i = 1; i <= count; ++i) {
      const Eigen::Vector3d p = p_laser + ahead * (static_cast<double>(i) / count);
      areas.push_back({p.x(), p.y(), radius, false});
    }
  }
  return areas;
}

namespace {

constexpr double kFreshPose = 0.05;  // [s] an older pose does not tell what a beam met

// What the beams met near the persons, on the ground of the fixed frame.
std::vector<Eigen::Vector2d> hits_near(const std::vector<Person>& persons, const Scan& scan,
                                       const LaserPose& pose, double gate) {
  const Eigen::Isometry3d T_fixed_laser = pose.T_laser_fixed.inverse();
  std::vector<double> distances;
  for (const Person& person : persons)
    distances.push_back((pose.T_laser_fixed * person.position).head<2>().norm());
  std::vector<Eigen::Vector2d> hits;
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    const double range = scan.ranges[i];
    if (!(range >= scan.range_min && range <= scan.range_max)) continue;
    const bool near = std::any_of(distances.begin(), distances.end(), [&](double distance) {
      return std::abs(range - distance) <= gate;
    });
    if (!near) continue;
    const double angle = scan.angle_min + static_cast<double>(i) * scan.angle_increment;
    const Eigen::Vector3d p_laser(range * std::cos(angle), range * std::sin(angle), 0.0);
    hits.emplace_back((T_fixed_laser * p_laser).head<2>());
  }
  return hits;
}

}  // namespace

Pipeline::Result Pipeline::merge(const Scan& scan, double time,
                                 const std::optional<LaserPose>& pose, const Outline& robot) {
  const MemoryParameters& memory = params_.memory;
  if (pose && pose->age <= kFreshPose && memory.laser_hold_time > 0.0) {
    const auto persons = memory_.at(time);
    const Eigen::Vector3d laser = pose->T_laser_fixed.inverse().translation();
    if (!persons.empty())
      memory_.follow(hits_near(persons, scan, *pose, 2.0 * memory.laser_gate), laser.head<2>(),
                     time);
  }
  Result result;
  result.persons = memory_.at(time);
  if (pose) result.areas = safety_areas(result.persons, time, *pose, params_.area);
  result.scan = safety_area::merge(scan, result.areas, params_.merge, robot);
  return result;
}

}  // namespace safe_passage::safety_area
