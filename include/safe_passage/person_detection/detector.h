// RGB-D person detector, the whole chain (paper 002, section 2.2 and Fig. 3).
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "safe_passage/person_detection/clustering.h"
#include "safe_passage/person_detection/confidence.h"
#include "safe_passage/person_detection/ground_plane.h"
#include "safe_passage/person_detection/types.h"
#include "safe_passage/person_detection/voxel_grid.h"

namespace safe_passage::person_detection {

enum class Method { kHog, kYolo };

struct DetectorParameters {
  Method method = Method::kHog;
  VoxelParameters voxel;
  GroundParameters ground;
  ClusterParameters clusters;
  HeadParameters heads;
  HogParameters hog;
  YoloParameters yolo;
};

struct DetectionResult {
  int voxels = 0;  // finite ones in the frame
  GroundEstimate ground;
  Points points;                      // over the ground, ground frame
  std::vector<Indices> clusters;      // of points
  std::vector<Detection> detections;  // every candidate, accepted or not
  std::vector<StageTime> times;
};

class PersonDetector {
 public:
  // Throws std::runtime_error naming the parameter at fault, a YOLO model that cannot be used too.
  explicit PersonDetector(const DetectorParameters& parameters);

  // `ground_seed`: the ground as tf or a parameter has it, in the frame's camera. While the ground
  // was never seen and there is no seed, nothing is detected (ground.state = kUnknown).
  DetectionResult detect(const RgbdFrame& frame, const std::optional<GroundPlane>& ground_seed);

  // Other thresholds, sizes and voxels from the next frame on; the ground stays. The method, and
  // what its model was made with, stay as they are.
  void tune(const DetectorParameters& parameters);

  // Forgets the ground: after a clock jump or a change of camera.
  void reset() { ground_.reset(); }

  const DetectorParameters& parameters() const { return parameters_; }

 private:
  double threshold() const;
  // A shoulder or a raised arm can pass for a second head: of several on one body, the surest.
  void reject_doubles(std::vector<Detection>& detections) const;
  void add_from_picture(DetectionResult& result, const std::vector<Box>& boxes,
                        const Intrinsics& camera) const;
  bool is_known(const Candidate& candidate, const std::vector<Detection>& detections) const;

  DetectorParameters parameters_;
  VoxelGrid voxels_;
  GroundTracker ground_;
  std::unique_ptr<PersonConfidence> confidence_;
};

// Fills in the candidates' image ROIs: as wide as the body, from the head down to the ground.
void project_rois(std::vector<Candidate>& candidates, const Points& points,
                  const GroundPlane& ground, const Intrinsics& camera);

}  // namespace safe_passage::person_detection
