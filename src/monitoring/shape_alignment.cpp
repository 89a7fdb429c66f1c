#include "safe_passage/monitoring/shape_alignment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <unordered_map>

namespace safe_passage::monitoring {

ShapeAligner::ShapeAligner(double cell, double reach)
    : cell_(cell),
      fine_(cell / kFine),
      reach_(kFine * static_cast<int>(std::lround(reach / cell))),
      origin_(Eigen::Vector2d::Zero()) {}

Alignment ShapeAligner::align(const Points& hypothesis, const Points& object) {
  return align_by(&ShapeAligner::branch_and_bound, hypothesis, object);
}

Alignment ShapeAligner::align_exhaustively(const Points& hypothesis, const Points& object) {
  return align_by(&ShapeAligner::try_all, hypothesis, object);
}

Alignment ShapeAligner::align_by(Search search, const Points& hypothesis, const Points& object) {
  if (hypothesis.empty() || object.empty())
    return {Eigen::Vector2d::Zero(), 0.0, Eigen::Matrix2d::Zero()};
  paint(object);
  place(hypothesis);
  const Alignment result = describe((this->*search)(), std::min(hypothesis.size(), object.size()));
  wipe();
  return result;
}

void ShapeAligner::Found::offer(Step other, int other_value) {
  if (other_value < value) return;
  const bool shorter =
      other.squared() < step.squared() || (other.squared() == step.squared() &&
                                           std::pair(other.y, other.x) < std::pair(step.y, step.x));
  if (other_value == value && !shorter) return;
  step = other;
  value = other_value;
}

// The object's weights; the map has room for the largest displacement and what is looked up there.
void ShapeAligner::paint(const Points& object) {
  Eigen::Vector2d low = object.front(), high = object.front();
  for (const Eigen::Vector2d& point : object) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  const double margin = 3.0 * cell_;
  origin_ = low - Eigen::Vector2d::Constant(margin);
  const Eigen::Vector2d size = (high - low) / cell_ + Eigen::Vector2d::Constant(7.0);
  width_ = static_cast<int>(std::ceil(size.x()));
  height_ = static_cast<int>(std::ceil(size.y()));
  const auto cells = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
  if (most_.size() < cells) {
    most_.resize(cells, 0);
    weight_.resize(cells * kFine * kFine, 0);
  }
  for (const Eigen::Vector2d& point : joined(object)) paint(point);
}

// The points, and between those of neighbouring cells three more, so that a wall is the same all
// along: where in its cell a point lies follows the robot, not the wall.
Points ShapeAligner::joined(const Points& object) const {
  std::unordered_map<int, std::vector<int>> bins;
  const auto bin = [this](const Eigen::Vector2d& point) {
    const Eigen::Vector2d at = (point - origin_) / cell_;
    return static_cast<int>(at.y()) * width_ + static_cast<int>(at.x());
  };
  Points all = object;
  for (std::size_t i = 0; i < object.size(); ++i) {
    const int own = bin(object[i]);
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const auto found = bins.find(own + dy * width_ + dx);
        if (found == bins.end()) continue;
        for (const int other : found->second)
          for (int part = 1; part < kFine; ++part)
            all.push_back(object[i] +
                          (object[static_cast<std::size_t>(other)] - object[i]) * part / kFine);
      }
    }
    bins[own].push_back(static_cast<int>(i));
  }
  return all;
}

void ShapeAligner::paint(const Eigen::Vector2d& point) {
  const int row = width_ * kFine;
  const Eigen::Vector2d at = (point - origin_) / fine_;
  const int first_x = static_cast<int>(std::floor(at.x())) - kFine;
  const int first_y = static_cast<int>(std::floor(at.y())) - kFine;
  for (int y = first_y; y <= first_y + 2 * kFine; ++y) {
    for (int x = first_x; x <= first_x + 2 * kFine; ++x) {
      const double distance = std::hypot(x + 0.5 - at.x(), y + 0.5 - at.y()) / kFine;
      const auto value = static_cast<std::uint8_t>(std::max(0.0, kFull * (1.0 - distance)));
      std::uint8_t& weight = weight_[static_cast<std::size_t>(y * row + x)];
      if (value <= weight) continue;
      if (weight == 0) painted_.push_back(y * row + x);
      weight = value;
      // cell c looks at the quarter cells 4 c to 4 c + 6
      for (int cy = (y - 3) / kFine; cy <= y / kFine; ++cy) {
        for (int cx = (x - 3) / kFine; cx <= x / kFine; ++cx) {
          std::uint8_t& most = most_[static_cast<std::size_t>(cy * width_ + cx)];
          if (most == 0) marked_.push_back(cy * width_ + cx);
          most = std::max(most, value);
        }
      }
    }
  }
}

void ShapeAligner::wipe() {
  for (const int at : painted_) weight_[static_cast<std::size_t>(at)] = 0;
  for (const int at : marked_) most_[static_cast<std::size_t>(at)] = 0;
  painted_.clear();
  marked_.clear();
}

void ShapeAligner::place(const Points& hypothesis) {
  placed_.clear();
  stay_ = kFull * static_cast<int>(hypothesis.size()) / (10 * kFine * kFine);
  for (const Eigen::Vector2d& point : hypothesis) {
    const Eigen::Vector2d at = (point - origin_) / fine_;
    placed_.push_back({static_cast<int>(std::floor(at.x())), static_cast<int>(std::floor(at.y()))});
  }
}

int ShapeAligner::score(Step step) const {
  const int columns = width_ * kFine, rows = height_ * kFine;
  int sum = 0;
  for (const Step& at : placed_) {
    const int x = at.x + step.x, y = at.y + step.y;
    if (x >= 0 && x < columns && y >= 0 && y < rows)
      sum += weight_[static_cast<std::size_t>(y * columns + x)];
  }
  return sum;
}

// No displacement of the 4 x 4 from `corner` on scores more.
int ShapeAligner::bound(Step corner) const {
  int sum = 0;
  for (const Step& at : placed_) {
    const int x = (at.x + corner.x) >> 2, y = (at.y + corner.y) >> 2;  // floor, negative too
    if (x >= 0 && x < width_ && y >= 0 && y < height_)
      sum += most_[static_cast<std::size_t>(y * width_ + x)];
  }
  return sum;
}

ShapeAligner::Found ShapeAligner::branch_and_bound() const {
  struct Box {
    Step corner;
    int bound;
    int nearest;  // squared length of its shortest displacement
  };
  const auto shortest = [](int low) { return low > 0 ? low : std::min(0, low + kFine - 1); };
  std::vector<Box> boxes;
  for (int y = -reach_; y <= reach_; y += kFine)
    for (int x = -reach_; x <= reach_; x += kFine)
      boxes.push_back({{x, y}, bound({x, y}), Step{shortest(x), shortest(y)}.squared()});
  for (Box& box : boxes) box.bound -= stay_ * box.nearest;
  std::sort(boxes.begin(), boxes.end(), [](const Box& a, const Box& b) {
    return a.bound != b.bound ? a.bound > b.bound : a.nearest < b.nearest;
  });
  Found best{{0, 0}, value({0, 0})};
  for (const Box& box : boxes) {
    if (box.bound < best.value) break;
    if (box.bound == best.value && box.nearest > best.step.squared()) continue;
    for (int y = box.corner.y; y < std::min(box.corner.y + kFine, reach_ + 1); ++y)
      for (int x = box.corner.x; x < std::min(box.corner.x + kFine, reach_ + 1); ++x)
        best.offer({x, y}, value({x, y}));
  }
  return best;
}

ShapeAligner::Found ShapeAligner::try_all() const {
  Found best{{0, 0}, value({0, 0})};
  for (int y = -reach_; y <= reach_; ++y)
    for (int x = -reach_; x <= reach_; ++x) best.offer({x, y}, value({x, y}));
  return best;
}

Alignment ShapeAligner::describe(const Found& found, std::size_t smaller) const {
  Alignment result;
  const int full = score(found.step);
  // `step` leads the hypothesis back onto the object
  result.displacement = -fine_ * Eigen::Vector2d(found.step.x, found.step.y);
  result.overlap = std::min(1.0, static_cast<double>(full) / (kFull * double(smaller)));
  if (full <= 0) {
    result.information.setZero();
    return result;
  }
  // By half a cell each way; the loss grows with the distance, its square with the square. At the
  // end of a thin line a cell may come and go with the view: that is no loss.
  const auto squared_loss = [&](int x, int y) {
    const int half = kFine / 2;
    const Step there{found.step.x + half * x, found.step.y + half * y};
    const Step back{found.step.x - half * x, found.step.y - half * y};
    const double mean = 0.5 * (score(there) + score(back));
    const double cells = 2.0 * std::max(0.0, (full - mean) / kFull - 0.5);
    return cells * cells / static_cast<double>(placed_.size());
  };
  const double cross = 0.25 * (squared_loss(1, 1) - squared_loss(1, -1));
  result.information << squared_loss(1, 0), cross, cross, squared_loss(0, 1);
  return result;
}

}  // namespace safe_passage::monitoring
