// Similar line segments make planes (paper 003, sections II-B and II-C).
#pragma once

#include <Eigen/Core>
#include <vector>

namespace safe_passage::scan_segmentation {

struct ClusterParameters {
  double similar_distance;  // [m] between end points of similar segments
  double similar_angle;     // [rad] between them
  int first_fit;            // similar segments from which a plane is estimated
  int refit_every;          // segments, and whenever their number has doubled
  int plane_segments;       // of a plane, at least
  double tolerance;         // [m] of a segment's ends from its plane
  double merge_angle;       // [rad] between planes that are one
  double line_spacing;      // [rad] between lines
  bool closed;              // the last line is the first one's neighbour
};

// Sums over points: enough to fit a plane to any number of segments.
struct Moments {
  double n = 0.0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();

  void add(const Eigen::Vector3d& point);
  void operator+=(const Moments& other);
};

struct Line3d {
  int row;
  Eigen::Vector3d start, end;  // [m], the scanner at the origin
  Moments moments;             // of its points
};

struct Plane {
  Eigen::Vector3d normal;  // towards the scanner
  double offset;           // [m] normal . p + offset = 0
  double rms;              // [m] of its points
  Moments moments;
};

struct Clusters {
  std::vector<int> plane;  // of each segment, -1: none
  std::vector<Plane> planes;
};

// Segments sorted by row. Each that belongs to no plane yet begins one: similar segments of the
// lines that follow join; from `first_fit` on they are held against the plane equation and against
// the last that joined; from `plane_segments` on all segments, wherever they are, against the
// equation alone.
Clusters cluster(const std::vector<Line3d>& lines, int rows, const ClusterParameters& p);

}  // namespace safe_passage::scan_segmentation
