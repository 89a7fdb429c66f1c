// Line segments of scan lines, each line an image in its own plane (paper 003, section II-A).
#pragma once

#include <Eigen/Core>
#include <vector>

namespace safe_passage::scan_segmentation {

struct LineParameters {
  double tolerance;  // [m] of a point from its segment
  int points;        // a segment has at least
  double length;     // [m] a segment has at least
  double gap;        // [m] between neighbours on one segment
  double gap_share;  // of their distance from the scanner, the same
};

struct Segment {
  int row, first, last;        // its points: line, first and last column
  Eigen::Vector2d start, end;  // [m] first and last point, on the fitted line
};

// Segments of one line of points (W, 2) [m], NaN where nothing was hit; in the order of the points.
//
// In place of the Hough transform of an image: the points come in order, so a run is split where it
// is farthest from its chord until a line fits each part (Ramer, Douglas and Peucker), and
// neighbours that one line fits are joined again. Lines are fitted by least squares.
std::vector<Segment> find_segments(const double* uv, int count, int row, const LineParameters& p);

}  // namespace safe_passage::scan_segmentation
