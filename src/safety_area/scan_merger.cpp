#include "safe_passage/safety_area/scan_merger.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "safe_passage/separation/shape_distance.h"

namespace safe_passage::safety_area {
namespace {

using separation::RobotShape;

constexpr double kTurn = 2.0 * M_PI;
constexpr double kLeastRange = 0.01;  // [m] 0 is read as "no return" by many
constexpr float kNoRange = std::numeric_limits<float>::infinity();

ScanFault check(const Scan& scan) {
  if (scan.ranges.empty()) return ScanFault::kEmpty;
  const double step = std::abs(scan.angle_increment);
  // Written so that NaN fails too.
  const bool has_angles = std::isfinite(scan.angle_min) && step > 0.0 && step < kTurn;
  const bool has_limits = scan.range_min < scan.range_max && scan.range_max > 0.0;
  if (!has_angles || !has_limits) return ScanFault::kBadGeometry;
  const double last_beam = (scan.angle_max - scan.angle_min) / scan.angle_increment;
  const double last_index = static_cast<double>(scan.ranges.size() - 1);
  return std::abs(last_beam - last_index) < 1.5 ? ScanFault::kNone : ScanFault::kBeamCount;
}

// The beams of a scan, each with the range at which it meets the nearest circle.
class Fan {
 public:
  explicit Fan(const Scan& scan)
      : first_(std::remainder(scan.angle_min, kTurn)),
        step_(scan.angle_increment),
        cos_(scan.ranges.size()),
        sin_(scan.ranges.size()),
        nearest_(scan.ranges.size(), std::numeric_limits<double>::infinity()) {
    // Each direction is the last one turned by a step: no trigonometry per beam.
    const double cos_step = std::cos(step_), sin_step = std::sin(step_);
    double c = std::cos(first_), s = std::sin(first_);
    for (std::size_t i = 0; i < nearest_.size(); ++i) {
      cos_[i] = c;
      sin_[i] = s;
      c = cos_[i] * cos_step - sin_[i] * sin_step;
      s = sin_[i] * cos_step + cos_[i] * sin_step;
    }
  }

  // Needs the laser outside the circle.
  void draw(const Circle& circle) {
    const double bearing = std::atan2(circle.y, circle.x);  // equation 1
    const double half = std::asin(circle.radius / std::hypot(circle.x, circle.y));
    const double last = first_ + step_ * static_cast<double>(nearest_.size() - 1);
    const auto [least, most] = std::minmax({first_, last});
    // The arc is met once for every turn that brings it into the fan.
    for (double turns = std::ceil((least - bearing - half) / kTurn);
         bearing - half + turns * kTurn <= most; ++turns) {
      const double from = (bearing - half + turns * kTurn - first_) / step_;  // equation 2
      const double to = (bearing + half + turns * kTurn - first_) / step_;    // equation 3
      draw(circle, std::min(from, to), std::max(from, to));
    }
  }

  void block() { std::fill(nearest_.begin(), nearest_.end(), 0.0); }

  const std::vector<double>& ranges() const { return nearest_; }  // [m] +inf: meets no circle

 private:
  void draw(const Circle& circle, double from, double to) {
    const auto count = static_cast<double>(nearest_.size());
    const auto begin = static_cast<std::size_t>(std::clamp(std::ceil(from), 0.0, count));
    const auto end = static_cast<std::size_t>(std::clamp(std::floor(to) + 1.0, 0.0, count));
    const double x = circle.x, y = circle.y, square = circle.radius * circle.radius;
    for (std::size_t i = begin; i < end; ++i) {
      const double along = x * cos_[i] + y * sin_[i];   // d cos w
      const double across = x * sin_[i] - y * cos_[i];  // d sin w
      const double root = std::sqrt(std::max(0.0, square - across * across));
      nearest_[i] = std::min(nearest_[i], along - root);  // near root of equation 4
    }
  }

  double first_, step_;
  std::vector<double> cos_, sin_, nearest_;
};

// [m] from a circle's middle to the robot; the laser is part of it, also where it sticks out.
double distance_to_robot(const Circle& circle, const RobotShape& robot) {
  const Eigen::Vector2d middle(circle.x, circle.y);
  return std::min(middle.norm(), robot.distance(middle));
}

enum class Placing { kOutside, kInside, kIgnored };

Placing placing(const Circle& circle, const MergeParameters& params, const RobotShape& robot) {
  const double distance = std::hypot(circle.x, circle.y);
  if (!std::isfinite(distance) || !std::isfinite(circle.radius) || circle.radius <= 0.0)
    return Placing::kIgnored;
  // Shrinking acts before the circle reaches the robot, the others once the laser is inside.
  const bool shrink = params.inside_policy == InsidePolicy::kShrink;
  const double room = shrink ? distance_to_robot(circle, robot) - params.clearance : distance;
  return room > circle.radius ? Placing::kOutside : Placing::kInside;
}

// The laser is outside of what is returned, even where it touches the person. Of a circle without a
// body nothing may be left: a radius of 0.
Circle cut_back(const Circle& circle, const MergeParameters& params, const RobotShape& robot) {
  const double distance = std::hypot(circle.x, circle.y);
  const double least = std::min({params.body_radius, circle.radius, distance / 2.0});
  const double body = circle.body ? least : 0.0;
  const bool shrink = params.inside_policy == InsidePolicy::kShrink;
  const double room = distance_to_robot(circle, robot) - params.clearance;
  const double radius = shrink ? std::max(room, body) : body;
  return {circle.x, circle.y, radius, circle.body};
}

void draw_inside(Fan& fan, const Circle& circle, const MergeParameters& params,
                 const RobotShape& robot) {
  if (params.inside_policy == InsidePolicy::kBlock) return fan.block();
  if (circle.x == 0.0 && circle.y == 0.0) return;  // it lies in no direction
  const Circle rest = cut_back(circle, params, robot);
  if (rest.radius > 0.0) fan.draw(rest);
}

// Where a circle is nearer than what was measured, it takes the beam.
void overlay(const Scan& scan, const Fan& fan, const MergeParameters& params, MergedScan& merged) {
  const bool with_intensity = scan.intensities.size() == scan.ranges.size();
  const double least = std::max(scan.range_min, kLeastRange);
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    const auto drawn = static_cast<float>(std::max(fan.ranges()[i], least));
    if (drawn > scan.range_max || drawn == kNoRange) continue;
    merged.safety_ranges[i] = drawn;
    if (with_intensity) merged.safety_intensities[i] = params.intensity;
    const float real = scan.ranges[i];
    const bool measured = real >= scan.range_min && real <= scan.range_max && real > 0.0F;
    if (measured && real <= drawn) continue;
    merged.ranges[i] = drawn;
    if (with_intensity) merged.intensities[i] = params.intensity;
  }
}

}  // namespace

MergedScan merge(const Scan& scan, const std::vector<Circle>& circles,
                 const MergeParameters& params, const Outline& robot) {
  MergedScan merged;
  merged.ranges = scan.ranges;
  merged.intensities = scan.intensities;
  merged.safety_ranges.assign(scan.ranges.size(), kNoRange);
  merged.safety_intensities.assign(scan.intensities.size(), 0.0F);
  merged.fault = check(scan);
  const bool readable = merged.fault == ScanFault::kNone || merged.fault == ScanFault::kBeamCount;
  if (circles.empty() || !readable) return merged;

  Fan fan(scan);
  const RobotShape shape(robot, 0.0, {});  // of no corners: infinitely far
  for (const Circle& circle : circles) {
    const Placing where = placing(circle, params, shape);
    merged.ignored += where == Placing::kIgnored;
    merged.inside += where == Placing::kInside;
    if (where == Placing::kOutside) fan.draw(circle);
    if (where == Placing::kInside) draw_inside(fan, circle, params, shape);
  }
  overlay(scan, fan, params, merged);
  return merged;
}

}  // namespace safe_passage::safety_area
