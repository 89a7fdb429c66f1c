// Safety areas as circles, drawn into a 2D laser scan: paper 002, section 2.3, equations 1-5.
//
// The paper's arctan2(x_c, y_c) and psi = arccos(r / d) are misprints. Seen from the laser, a
// circle of radius r at distance d > r lies at the bearing atan2(y, x) and fills the half angle
// asin(r / d); on a beam at the offset w from the bearing it begins at d cos w - sqrt(r^2 - d^2
// sin^2 w), the near root of equation 4.
//
// What the paper leaves open, and is decided here:
// - Of several circles the nearest wins. A merged range is never longer than a valid measured one.
// - A valid measurement lies in [range_min, range_max] and is not 0. On every other beam (NaN,
//   +-inf, 0, too near, too far) nothing was measured, and the circle's range is written (REP 117).
// - A beam that no circle meets keeps its range and intensity bit by bit.
// - A circle nearer than range_min is drawn at range_min, where a costmap does not ignore it;
//   beyond range_max it is not drawn.
// - Beam i looks along angle_min + i * angle_increment, whatever the sign, also past +-pi and for
//   more than a turn: every consumer of a LaserScan reads it so. angle_max is only compared: a
//   scan whose number of beams disagrees with it is reported, and the circles are drawn all the
//   same, because leaving persons out would be the unsafe side.
// - A scan whose beams have no direction or no range limits passes through unchanged, reported.
// - A circle that is not finite, or of no radius, is ignored, counted.
// - A circle without a body is where a person may soon be. It is cut back before the robot like the
//   others, but leaves nothing behind once the robot is in it: nobody is there yet.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace safe_passage::safety_area {

struct Scan {
  double angle_min = 0.0;          // [rad] of beam 0
  double angle_max = 0.0;          // [rad] of the last beam
  double angle_increment = 0.0;    // [rad] negative: clockwise
  double range_min = 0.0;          // [m]
  double range_max = 0.0;          // [m]
  std::vector<float> ranges;       // [m]
  std::vector<float> intensities;  // as long as ranges, or the sensor has none
};

// In the laser's frame.
struct Circle {
  double x = 0.0, y = 0.0;  // [m]
  double radius = 0.0;      // [m]
  bool body = true;         // a person is in its middle
};

// What becomes of a circle that the robot is in, because a person came up to it.
enum class InsidePolicy {
  kShrink,  // pushed back to `clearance` before the robot: it may leave, not come nearer
  kBody,    // only the person's body remains: for robots that work hand in hand with people
  kBlock,   // every beam blocked: the robot must not move until the person has left
};

// Corners of the robot's footprint, in their order, on the ground of the laser's frame; empty: not
// known, the robot is where the laser is.
using Outline = std::vector<Eigen::Vector2d>;

struct MergeParameters {
  InsidePolicy inside_policy = InsidePolicy::kShrink;
  // [m] that stays free between a shrunk circle and the robot's outline, or the laser where the
  // outline is not known. More: the robot could push a circle along; less: it could be trapped.
  double clearance = 0.3;
  double body_radius = 0.25;  // [m] of a person, least radius a circle shrinks to
  float intensity = 0.0F;     // of a beam that ends on a circle
};

enum class ScanFault {
  kNone,
  kEmpty,        // no beams: passed through
  kBadGeometry,  // angles or range limits without a meaning: passed through
  kBeamCount,    // disagrees with angle_max by more than one beam: merged
};

struct MergedScan {
  std::vector<float> ranges;         // [m] nearest of measurement and circles
  std::vector<float> intensities;    // as in the scan, `intensity` on the circles
  std::vector<float> safety_ranges;  // [m] the circles alone, +inf: none
  std::vector<float>
      safety_intensities;  // `intensity` on the circles, 0 elsewhere; as long as the scan's
  ScanFault fault = ScanFault::kNone;
  int inside = 0;   // circles that the inside policy was applied to
  int ignored = 0;  // circles that are not finite or have no radius
};

MergedScan merge(const Scan& scan, const std::vector<Circle>& circles,
                 const MergeParameters& params = {}, const Outline& robot = {});

}  // namespace safe_passage::safety_area
