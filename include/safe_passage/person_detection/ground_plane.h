// Ground plane by RANSAC and least squares, seeded by the last frame (paper 002, section 2.2).
#pragma once

#include <optional>
#include <random>

#include "safe_passage/person_detection/types.h"

namespace safe_passage::person_detection {

struct GroundParameters {
  double seed_band = 0.25;        // [m] first fit: points this near to a seed from tf or parameter
  double track_band = 0.10;       // [m] later fits: points this near to the last frame's plane
  double inlier_distance = 0.05;  // [m]
  double max_tilt = 0.26;         // [rad] between an estimate and its seed
  double max_height_change = 0.30;  // [m] between an estimate's and its seed's camera height
  int min_inliers = 150;            // voxels; with fewer the ground is not seen
  int iterations = 80;              // RANSAC
};

enum class GroundState {
  kTracked,  // fitted in this frame
  kHeld,     // not seen in this frame: the last estimate (or the seed) is used on
  kUnknown,  // never seen and no seed
};

struct GroundEstimate {
  GroundPlane plane;
  GroundState state = GroundState::kUnknown;
  int inliers = 0;
};

class GroundTracker {
 public:
  explicit GroundTracker(const GroundParameters& parameters) : parameters_(parameters) {}

  // Other parameters from the next frame on; the ground known so far stays.
  void tune(const GroundParameters& parameters) { parameters_ = parameters; }

  // `seed`: the ground as tf or a parameter has it. The estimate may not leave its neighbourhood
  // (max_tilt, max_height_change), so a table or a wall never becomes the ground.
  GroundEstimate update(const Points& voxels, const std::optional<GroundPlane>& seed);

  // As new: what follows does not depend on what was before.
  void reset() {
    last_.reset();
    random_.seed(1);
  }

 private:
  std::optional<GroundEstimate> fit(const Points& voxels, const GroundPlane& near, double band);
  bool plausible(const GroundPlane& plane, const GroundPlane& reference) const;

  GroundParameters parameters_;
  std::optional<GroundPlane> last_;
  std::mt19937 random_{1};
};

// The ground without any seed: the lowest large plane whose normal is within `max_tilt` [rad] of
// `up` (unit, optical frame) and which lies under the camera. None: there is no such plane.
std::optional<GroundPlane> find_ground(const Points& voxels, const Eigen::Vector3f& up,
                                       double max_tilt, const GroundParameters& parameters = {});

}  // namespace safe_passage::person_detection
