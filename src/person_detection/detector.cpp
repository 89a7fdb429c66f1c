#include "safe_passage/person_detection/detector.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <utility>

#include "safe_passage/person_detection/box_candidates.h"

namespace safe_passage::person_detection {
namespace {

class StopWatch {
 public:
  explicit StopWatch(std::vector<StageTime>& times) : times_(times) {}
  void lap(const char* stage) {
    const auto now = std::chrono::steady_clock::now();
    times_.push_back({stage, std::chrono::duration<double, std::milli>(now - last_).count()});
    last_ = now;
  }

 private:
  std::vector<StageTime>& times_;
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

constexpr float kSameBody = 0.3F;  // intersection over union of two ROIs; in a queue less

std::unique_ptr<PersonConfidence> make_confidence(const DetectorParameters& parameters) {
  if (parameters.method == Method::kYolo) return std::make_unique<YoloConfidence>(parameters.yolo);
  return std::make_unique<HogConfidence>(parameters.hog);
}

}  // namespace

PersonDetector::PersonDetector(const DetectorParameters& parameters)
    : parameters_(parameters),
      voxels_(parameters.voxel),
      ground_(parameters.ground),
      confidence_(make_confidence(parameters)) {}

void PersonDetector::tune(const DetectorParameters& parameters) {
  const DetectorParameters old = std::exchange(parameters_, parameters);
  parameters_.method = old.method;
  parameters_.hog.shifts = old.hog.shifts;
  parameters_.hog.sizes = old.hog.sizes;
  const double threshold = parameters_.yolo.threshold;
  parameters_.yolo = old.yolo;
  parameters_.yolo.threshold = threshold;
  voxels_ = VoxelGrid(parameters_.voxel);
  ground_.tune(parameters_.ground);
}

DetectionResult PersonDetector::detect(const RgbdFrame& frame,
                                       const std::optional<GroundPlane>& ground_seed) {
  DetectionResult result;
  StopWatch watch(result.times);
  const Points voxels = voxels_.filter(frame.xyz, frame.depth_focal());
  result.voxels = static_cast<int>(voxels.size());
  watch.lap("voxel filter");
  result.ground = ground_.update(voxels, ground_seed);
  watch.lap("ground plane");
  if (result.ground.state == GroundState::kUnknown) return result;
  result.points = above_ground(voxels, result.ground.plane, parameters_.clusters);
  watch.lap("ground removal");
  result.clusters = euclidean_clusters(result.points, parameters_.clusters);
  watch.lap("clusters");
  auto candidates = head_subclusters(result.points, result.clusters, parameters_.heads);
  project_rois(candidates, result.points, result.ground.plane, frame.camera);
  watch.lap("head sub-clusters");
  const auto [scores, unmatched] = confidence_->score(frame.bgr, candidates);
  watch.lap(parameters_.method == Method::kYolo ? "confidence YOLO" : "confidence HOG");
  for (std::size_t i = 0; i < candidates.size(); ++i)
    result.detections.push_back({std::move(candidates[i]), scores[i], scores[i] >= threshold()});
  reject_doubles(result.detections);
  add_from_picture(result, unmatched, frame.camera);
  watch.lap("candidates of the picture");
  return result;
}

void PersonDetector::reject_doubles(std::vector<Detection>& detections) const {
  std::vector<Detection*> accepted;
  for (Detection& detection : detections)
    if (detection.accepted) accepted.push_back(&detection);
  std::stable_sort(accepted.begin(), accepted.end(), [](const Detection* a, const Detection* b) {
    return a->confidence > b->confidence;
  });
  std::vector<Detection> kept;
  for (Detection* detection : accepted) {
    detection->accepted = !is_known(detection->candidate, kept);
    if (detection->accepted) kept.push_back(*detection);
  }
}

void PersonDetector::add_from_picture(DetectionResult& result, const std::vector<Box>& boxes,
                                      const Intrinsics& camera) const {
  if (!parameters_.yolo.propose) return;
  for (const Box& box : boxes) {
    if (box.probability < threshold()) continue;
    auto candidate =
        candidate_in_box(box, result.points, result.ground.plane, camera, parameters_.heads);
    if (candidate && !is_known(*candidate, result.detections))
      result.detections.push_back({std::move(*candidate), box.probability, true});
  }
}

bool PersonDetector::is_known(const Candidate& candidate,
                              const std::vector<Detection>& detections) const {
  return std::any_of(detections.begin(), detections.end(), [&](const Detection& other) {
    const Eigen::Vector2f apart = (other.candidate.head - candidate.head).head<2>();
    return other.accepted && apart.norm() < parameters_.heads.body_radius &&
           overlap(other.candidate.roi, candidate.roi) > kSameBody;
  });
}

double PersonDetector::threshold() const {
  return parameters_.method == Method::kYolo ? parameters_.yolo.threshold
                                             : parameters_.hog.threshold;
}

void project_rois(std::vector<Candidate>& candidates, const Points& points,
                  const GroundPlane& ground, const Intrinsics& camera) {
  constexpr float kNearest = 0.1F;  // [m] in front of the camera
  const GroundFrame frame(ground);
  for (Candidate& candidate : candidates) {
    Eigen::Vector3f middle = Eigen::Vector3f::Zero();
    double left = std::numeric_limits<double>::max(), right = -left;
    for (const int i : candidate.points) {
      middle += points[i];
      const Eigen::Vector3f p = frame.to_camera(points[i]);
      if (p.z() < kNearest) continue;
      const double u = camera.project(p).x;
      left = std::min(left, u);
      right = std::max(right, u);
    }
    middle /= static_cast<float>(candidate.points.size());
    const Eigen::Vector3f top = frame.to_camera({middle.x(), middle.y(), candidate.head.z()});
    const Eigen::Vector3f feet = frame.to_camera({middle.x(), middle.y(), 0.0F});
    if (top.z() < kNearest || feet.z() < kNearest || left > right) continue;  // no ROI: no score
    const double upper = camera.project(top).y, lower = camera.project(feet).y;
    candidate.roi = {cv::Point(cvRound(left), cvRound(upper)),
                     cv::Point(cvRound(right) + 1, cvRound(lower) + 1)};
  }
}

}  // namespace safe_passage::person_detection
