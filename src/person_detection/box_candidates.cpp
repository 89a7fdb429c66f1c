#include "safe_passage/person_detection/box_candidates.h"

#include <algorithm>
#include <cmath>

namespace safe_passage::person_detection {
namespace {

constexpr float kNearest = 0.1F;     // [m] in front of the camera
constexpr float kThickness = 0.5F;   // [m] of a body with its arms, along the line of sight
constexpr float kHiddenHead = 0.4F;  // [m] that the highest visible point may lie under the head

cv::Rect2f middle_of(const cv::Rect2f& box) {
  return {box.x + 0.25F * box.width, box.y + 0.05F * box.height, 0.5F * box.width,
          0.7F * box.height};
}

float distance(const Eigen::Vector3f& p) { return std::hypot(p.x(), p.y()); }

Indices points_in(const cv::Rect2f& area, const Points& points, const GroundFrame& frame,
                  const Intrinsics& camera) {
  Indices inside;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3f p = frame.to_camera(points[i]);
    if (p.z() > kNearest && area.contains(cv::Point2f(camera.project(p))))
      inside.push_back(static_cast<int>(i));
  }
  return inside;
}

// Start of the stretch of kThickness that holds most of the sorted distances. Voxels thin out with
// the square of the distance, so each counts by it.
float densest(const std::vector<float>& sorted) {
  float best = 0.0F, start = sorted.front(), weight = 0.0F;
  for (std::size_t from = 0, to = 0; from < sorted.size(); ++from) {
    for (; to < sorted.size() && sorted[to] <= sorted[from] + kThickness; ++to)
      weight += sorted[to] * sorted[to];
    if (weight > best) best = weight, start = sorted[from];
    weight -= sorted[from] * sorted[from];
  }
  return start;
}

}  // namespace

std::optional<Candidate> candidate_in_box(const Box& box, const Points& points,
                                          const GroundPlane& ground, const Intrinsics& camera,
                                          const HeadParameters& parameters) {
  const GroundFrame frame(ground);
  std::vector<float> distances;
  for (const int i : points_in(middle_of(box.rect), points, frame, camera))
    distances.push_back(distance(points[i]));
  if (distances.empty()) return std::nullopt;
  std::sort(distances.begin(), distances.end());
  const float near = densest(distances), far = near + kThickness;

  Candidate candidate;
  Eigen::Vector3f low = Eigen::Vector3f::Constant(1e9F), high = -low, middle = {0.0F, 0.0F, 0.0F};
  for (const int i : points_in(box.rect, points, frame, camera)) {
    const float d = distance(points[i]);
    if (d < near || d > far) continue;
    candidate.points.push_back(i);
    low = low.cwiseMin(points[i]);
    high = high.cwiseMax(points[i]);
    middle += points[i];
  }
  const bool enough = static_cast<int>(candidate.points.size()) >= parameters.min_points;
  if (!enough || high.z() - low.z() < parameters.min_extent ||
      high.z() < parameters.min_height - kHiddenHead || high.z() > parameters.max_height)
    return std::nullopt;
  middle /= static_cast<float>(candidate.points.size());
  candidate.head = {middle.x(), middle.y(), high.z()};
  candidate.low = low;
  candidate.high = high;
  candidate.roi = box.rect;
  return candidate;
}

}  // namespace safe_passage::person_detection
