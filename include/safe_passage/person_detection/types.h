// What passes between the stages of the person detector. Metres and radians throughout; points are
// in the camera's optical frame (x right, y down, z forward; REP 103) unless the name says
// otherwise.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace safe_passage::person_detection {

struct Intrinsics {
  double fx = 0.0, fy = 0.0, cx = 0.0, cy = 0.0;  // [px]

  cv::Point2d project(const Eigen::Vector3f& p) const {
    return {fx * p.x() / p.z() + cx, fy * p.y() / p.z() + cy};
  }
};

struct RgbdFrame {
  cv::Mat xyz;        // CV_32FC3, organised, NaN where there is no return
  cv::Mat bgr;        // CV_8UC3, rectified, registered to xyz; its size may differ
  Intrinsics camera;  // of bgr

  // [px] focal length in the pixels of xyz
  double depth_focal() const { return bgr.empty() ? camera.fx : camera.fx * xyz.cols / bgr.cols; }
};

// Height over the ground of a point p: normal . p + offset. The normal is unit and points up.
struct GroundPlane {
  Eigen::Vector3f normal = Eigen::Vector3f(0.0F, -1.0F, 0.0F);
  float offset = 0.0F;  // the camera's own height

  float height(const Eigen::Vector3f& p) const { return normal.dot(p) + offset; }
};

// Rotation and translation into a frame whose z is height over the ground, its origin under the
// camera.
struct GroundFrame {
  Eigen::Matrix3f R;  // R_ground_camera
  float offset;

  explicit GroundFrame(const GroundPlane& plane);
  Eigen::Vector3f to_ground(const Eigen::Vector3f& p) const {
    return R * p + Eigen::Vector3f(0.0F, 0.0F, offset);
  }
  Eigen::Vector3f to_camera(const Eigen::Vector3f& p) const {
    return R.transpose() * (p - Eigen::Vector3f(0.0F, 0.0F, offset));
  }
};

using Points = std::vector<Eigen::Vector3f>;
using Indices = std::vector<int>;

// One upright thing that may be a person: a sub-cluster centred on a peak of the height map.
struct Candidate {
  Indices points;             // into the points over the ground
  Eigen::Vector3f head;       // the peak, ground frame
  Eigen::Vector3f low, high;  // bounding box, ground frame
  float headness = 0.0F;      // share of the ring around the head that is clearly lower, 0 to 1
  cv::Rect roi;               // head to feet in the image [px]; may reach beyond its border
};

struct Detection {
  Candidate candidate;
  float confidence = 0.0F;  // the scorer's own scale
  bool accepted = false;
};

struct StageTime {
  std::string stage;
  double ms;
};

}  // namespace safe_passage::person_detection
