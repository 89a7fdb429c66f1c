#include "safe_passage/person_detection/ground_plane.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace safe_passage::person_detection {
namespace {

// Plane through three points, its normal on the side of `up`.
std::optional<GroundPlane> plane_through(const Eigen::Vector3f& a, const Eigen::Vector3f& b,
                                         const Eigen::Vector3f& c, const Eigen::Vector3f& up) {
  const Eigen::Vector3f cross = (b - a).cross(c - a);
  if (cross.norm() < 1e-3F) return std::nullopt;
  GroundPlane plane;
  plane.normal = cross.normalized() * (cross.dot(up) < 0.0F ? -1.0F : 1.0F);
  plane.offset = -plane.normal.dot(a);
  return plane;
}

Points near_plane(const Points& points, const GroundPlane& plane, double band) {
  Points near;
  for (const auto& p : points)
    if (std::abs(plane.height(p)) < band) near.push_back(p);
  return near;
}

int count_inliers(const Points& points, const GroundPlane& plane, float distance) {
  return static_cast<int>(std::count_if(points.begin(), points.end(), [&](const auto& p) {
    return std::abs(plane.height(p)) < distance;
  }));
}

GroundPlane least_squares(const Points& points, const Eigen::Vector3f& up) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& p : points) mean += p.cast<double>();
  mean /= static_cast<double>(points.size());
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const auto& p : points) {
    const Eigen::Vector3d q = p.cast<double>() - mean;
    scatter += q * q.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(scatter);
  Eigen::Vector3d normal = solver.eigenvectors().col(0);
  if (normal.dot(up.cast<double>()) < 0.0) normal = -normal;
  return {normal.cast<float>(), static_cast<float>(-normal.dot(mean))};
}

double tilt(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  return std::acos(std::clamp(a.dot(b), -1.0F, 1.0F));
}

// The plane with most inliers among `iterations` drawn ones that `accept` lets pass.
template <typename Accept>
std::optional<GroundPlane> ransac(const Points& points, const Eigen::Vector3f& up, int iterations,
                                  float distance, std::mt19937& random, Accept accept) {
  if (points.size() < 3) return std::nullopt;
  std::uniform_int_distribution<std::size_t> draw(0, points.size() - 1);
  std::optional<GroundPlane> best;
  int most = 0;
  for (int i = 0; i < iterations; ++i) {
    const auto plane =
        plane_through(points[draw(random)], points[draw(random)], points[draw(random)], up);
    if (!plane || !accept(*plane)) continue;
    const int inliers = count_inliers(points, *plane, distance);
    if (inliers > most) {
      most = inliers;
      best = plane;
    }
  }
  return best;
}

}  // namespace

GroundFrame::GroundFrame(const GroundPlane& plane) : offset(plane.offset) {
  // x forward: the optical axis laid on the ground (or image-up where the camera looks straight
  // down).
  const Eigen::Vector3f z = plane.normal;
  Eigen::Vector3f forward = Eigen::Vector3f::UnitZ();
  if (std::abs(z.dot(forward)) > 0.99F) forward = -Eigen::Vector3f::UnitY();
  const Eigen::Vector3f x = (forward - z * z.dot(forward)).normalized();
  R.row(0) = x;
  R.row(1) = z.cross(x);
  R.row(2) = z;
}

GroundEstimate GroundTracker::update(const Points& voxels, const std::optional<GroundPlane>& seed) {
  std::optional<GroundEstimate> estimate;
  if (last_ && (!seed || plausible(*last_, *seed)))
    estimate = fit(voxels, *last_, parameters_.track_band);
  if (!estimate && seed) estimate = fit(voxels, *seed, parameters_.seed_band);  // lost: start again
  if (estimate && seed && !plausible(estimate->plane, *seed)) estimate.reset();
  if (estimate) {
    last_ = estimate->plane;
    return *estimate;
  }
  if (seed) return {last_ && plausible(*last_, *seed) ? *last_ : *seed, GroundState::kHeld, 0};
  if (last_) return {*last_, GroundState::kHeld, 0};
  return {};
}

std::optional<GroundEstimate> GroundTracker::fit(const Points& voxels, const GroundPlane& near,
                                                 double band) {
  const auto distance = static_cast<float>(parameters_.inlier_distance);
  const Points candidates = near_plane(voxels, near, band);
  const auto drawn = ransac(candidates, near.normal, parameters_.iterations, distance, random_,
                            [&](const GroundPlane& plane) { return plausible(plane, near); });
  if (!drawn) return std::nullopt;
  GroundPlane plane = *drawn;
  for (int refit = 0; refit < 2; ++refit) {
    const Points inliers = near_plane(candidates, plane, distance);
    if (static_cast<int>(inliers.size()) < parameters_.min_inliers) return std::nullopt;
    plane = least_squares(inliers, near.normal);
  }
  if (!plausible(plane, near)) return std::nullopt;
  return GroundEstimate{plane, GroundState::kTracked, count_inliers(candidates, plane, distance)};
}

bool GroundTracker::plausible(const GroundPlane& plane, const GroundPlane& reference) const {
  return tilt(plane.normal, reference.normal) <= parameters_.max_tilt &&
         std::abs(plane.offset - reference.offset) <= parameters_.max_height_change;
}

std::optional<GroundPlane> find_ground(const Points& voxels, const Eigen::Vector3f& up,
                                       double max_tilt, const GroundParameters& parameters) {
  std::mt19937 random(1);
  const auto distance = static_cast<float>(parameters.inlier_distance);
  Points rest = voxels;
  std::optional<GroundPlane> lowest;
  for (int attempt = 0; attempt < 4;
       ++attempt) {  // floor, tables, ceiling: the lowest one is meant
    const auto plane = ransac(
        rest, up, 10 * parameters.iterations, distance, random,
        [&](const GroundPlane& p) { return p.offset > 0.1F && tilt(p.normal, up) <= max_tilt; });
    if (!plane) break;
    const Points inliers = near_plane(rest, *plane, distance);
    if (static_cast<int>(inliers.size()) < parameters.min_inliers) break;
    const GroundPlane refined = least_squares(inliers, up);
    if (tilt(refined.normal, up) <= max_tilt && (!lowest || refined.offset > lowest->offset))
      lowest = refined;
    rest.erase(std::remove_if(rest.begin(), rest.end(),
                              [&](const auto& p) { return plane->height(p) > -distance; }),
               rest.end());  // only what lies lower is of interest now
  }
  return lowest;
}

}  // namespace safe_passage::person_detection
