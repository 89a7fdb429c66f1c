#include "safe_passage/separation/shape_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace safe_passage::separation {

RobotShape::RobotShape(std::vector<Eigen::Vector2d> corners, double padding,
                       std::vector<Capsule> parts)
    : padding_(padding) {
  for (std::size_t i = 0; i < corners.size(); ++i)
    platform_.push_back(edge(corners[i], corners[(i + 1) % corners.size()]));
  for (const Capsule& part : parts) {
    limbs_.push_back(edge(part.start, part.end));
    radii_.push_back(part.radius);
  }
}

RobotShape::Edge RobotShape::edge(const Eigen::Vector2d& start, const Eigen::Vector2d& end) {
  const Eigen::Vector2d along = end - start;
  const double squared = along.squaredNorm();
  return {start, along, end.y(), squared > 0.0 ? 1.0 / squared : 0.0};
}

double RobotShape::squared(const Edge& edge, const Eigen::Vector2d& point) {
  const Eigen::Vector2d to = point - edge.start;
  const double share = std::clamp(to.dot(edge.along) * edge.inverse_squared, 0.0, 1.0);
  return (to - share * edge.along).squaredNorm();
}

double RobotShape::distance(const Eigen::Vector2d& point) const {
  double nearest = std::numeric_limits<double>::infinity();
  bool inside = false;  // by the edges that a ray to the right crosses
  for (const Edge& edge : platform_) {
    nearest = std::min(nearest, squared(edge, point));
    const double height = point.y() - edge.start.y();
    if ((edge.start.y() > point.y()) != (edge.end_y > point.y()) &&
        point.x() < edge.start.x() + height / edge.along.y() * edge.along.x())
      inside = !inside;
  }
  double found = (inside ? -std::sqrt(nearest) : std::sqrt(nearest)) - padding_;
  for (std::size_t i = 0; i < limbs_.size(); ++i)
    found = std::min(found, std::sqrt(squared(limbs_[i], point)) - radii_[i]);
  return found;
}

}  // namespace safe_passage::separation
