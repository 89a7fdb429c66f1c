// The displacement under which two shapes overlap best, exactly (paper 000, section 4.3).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace safe_passage::monitoring {

using Points = std::vector<Eigen::Vector2d>;  // [m] one for each cell of a shape

struct Alignment {
  Eigen::Vector2d displacement;  // [m] of the hypothesis against the object
  double overlap;                // share of the smaller shape that lies on the other, 0 to 1
  // How many cells of the overlap a displacement u by one cell loses, as u^T information u: most of
  // them where the shapes fix the displacement, none along a wall.
  Eigen::Matrix2d information;
};

// Branch and bound over displacements on a grid of a quarter cell. A point of the hypothesis counts
// by its distance to the nearest point of the object: 1 on it, 0 a cell away and beyond, so that
// shapes are compared more finely than by whole cells. Boxes of 4 x 4 displacements are bounded by
// the best that each point could do in them. A displacement by a cell must win a tenth of the
// overlap, and in proportion to its square: along a wall all are nearly equal, and the end of what
// is in view must not choose.
class ShapeAligner {
 public:
  static constexpr int kFine = 4;    // displacements a cell
  static constexpr int kFull = 200;  // weight of a point that lies on the other

  // cell: [m] size of a grid cell; reach: [m] largest displacement along each axis, in whole cells.
  ShapeAligner(double cell, double reach);

  Alignment align(const Points& hypothesis, const Points& object);

  // The same by trying every displacement; for tests and benchmarks.
  Alignment align_exhaustively(const Points& hypothesis, const Points& object);

 private:
  struct Step {  // a displacement in quarter cells
    int x = 0, y = 0;
    int squared() const { return x * x + y * y; }
  };
  struct Found {
    Step step;
    int value = 0;  // its score less its cost
    void offer(Step other, int other_value);
  };

  using Search = Found (ShapeAligner::*)() const;

  Alignment align_by(Search search, const Points& hypothesis, const Points& object);
  void paint(const Points& object);
  void paint(const Eigen::Vector2d& point);
  Points joined(const Points& object) const;
  void wipe();
  void place(const Points& hypothesis);
  int score(Step step) const;
  int value(Step step) const { return score(step) - stay_ * step.squared(); }
  int bound(Step corner) const;
  Found branch_and_bound() const;
  Found try_all() const;
  Alignment describe(const Found& found, std::size_t smaller) const;

  double cell_, fine_;
  int reach_;                         // in quarter cells
  int width_ = 0, height_ = 0;        // of the map around the object, in cells
  Eigen::Vector2d origin_;            // [m] of the map
  std::vector<std::uint8_t> weight_;  // of each quarter cell
  std::vector<std::uint8_t> most_;    // of each cell: most in the quarter cells from its first on
  std::vector<int> painted_;          // quarter cells that are not 0
  std::vector<int> marked_;           // cells that are not 0
  int stay_ = 0;                      // cost of a displacement, times its square
  std::vector<Step> placed_;          // quarter cells of the hypothesis
};

}  // namespace safe_passage::monitoring
