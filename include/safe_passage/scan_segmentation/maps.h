// Maps of the ground: what of it was seen, and where a box fits (paper 003, section II-D).
#pragma once

#include <cstdint>
#include <vector>

namespace safe_passage::scan_segmentation {

struct Bytes {  // a map's cells, row by row
  std::uint8_t* cell;
  int rows, columns;
};

enum Vertex : std::uint8_t { kNothing = 0, kGround = 1, kFoot = 2 };
enum Cover : std::uint8_t { kUncovered = 0, kCovered = 1, kBeside = 2 };

// Triangles between neighbouring points of neighbouring lines, whose corners are no farther apart
// than `gap`, drawn into `map`: kCovered where all are ground, kBeside where others are feet of
// what stands on the ground.
//
// xyz: (H, W, 3) in cells, x along columns; z in cells, too. vertex: (H, W).
void draw_ground(const double* xyz, const std::uint8_t* vertex, int height, int width, bool closed,
                 double gap, double step, Bytes map);

// Sets the cells that rays pass over on the way from `from` to `to` (N, 2) in cells.
void draw_rays(const double* from, const double* to, int count, Bytes map);

// For each cell (row, column) the first of `angles` [rad] at which no blocked cell's middle lies in
// a box around it, -1: none. What is beyond the map's border is blocked. Half sizes in cells, of
// each angle.
std::vector<int> fit_box(Bytes blocked, const std::vector<int>& cells,
                         const std::vector<double>& angles, const std::vector<double>& half_length,
                         const std::vector<double>& half_width);

}  // namespace safe_passage::scan_segmentation
