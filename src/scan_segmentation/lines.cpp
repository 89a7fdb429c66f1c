#include "safe_passage/scan_segmentation/lines.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace safe_passage::scan_segmentation {
namespace {

using Run = std::pair<int, int>;  // first and last of a line's valid points

class Line {
 public:
  Line(const double* uv, int count, const LineParameters& p) : p_(p) {
    sums_.emplace_back(Sums::Zero());
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector2d at(uv[2 * i], uv[2 * i + 1]);
      if (!at.allFinite()) continue;
      columns_.push_back(i);
      points_.push_back(at);
      Sums add;
      add << at.x(), at.y(), at.x() * at.x(), at.x() * at.y(), at.y() * at.y();
      sums_.push_back(sums_.back() + add);
    }
  }

  std::vector<Run> runs() const {
    std::vector<Run> found;
    const int count = static_cast<int>(points_.size());
    for (int first = 0, i = 1; i <= count; ++i) {
      if (i < count && !gap(i)) continue;
      if (i - first >= p_.points) found.emplace_back(first, i - 1);
      first = i;
    }
    return found;
  }

  void split(Run run, std::vector<Run>* parts) const {
    if (run.second - run.first + 1 < 3) return;
    if (fits(run)) {
      parts->push_back(run);
      return;
    }
    const int at = farthest_from_chord(run);
    split({run.first, at}, parts);
    split({at + 1, run.second}, parts);
  }

  std::vector<Run> joined(const std::vector<Run>& parts) const {
    std::vector<Run> found;
    for (const Run& part : parts) {
      // a point or two between them lay off both: lost at a seam, or an outlier
      if (!found.empty() && part.first - found.back().second <= 3) {
        const Run both(found.back().first, part.second);
        if (fits(both)) {
          found.back() = both;
          continue;
        }
      }
      found.push_back(part);
    }
    return found;
  }

  bool segment(Run run, int row, Segment* found) const {
    if (run.second - run.first + 1 < p_.points) return false;
    const auto [centre, direction] = fit(run);
    const Eigen::Vector2d start = centre + direction * direction.dot(points_[run.first] - centre);
    const Eigen::Vector2d end = centre + direction * direction.dot(points_[run.second] - centre);
    if ((end - start).norm() < p_.length) return false;
    *found = {row, columns_[run.first], columns_[run.second], start, end};
    return true;
  }

 private:
  using Sums = Eigen::Matrix<double, 5, 1>;

  bool gap(int i) const {
    const double allowed = std::max(p_.gap, p_.gap_share * points_[i].norm());
    return (points_[i] - points_[i - 1]).norm() > allowed;
  }

  std::pair<Eigen::Vector2d, Eigen::Vector2d> fit(Run run) const {
    const Sums s = sums_[run.second + 1] - sums_[run.first];
    const double n = run.second - run.first + 1;
    const double uu = s(2) - s(0) * s(0) / n, uv = s(3) - s(0) * s(1) / n,
                 vv = s(4) - s(1) * s(1) / n;
    const double angle = 0.5 * std::atan2(2.0 * uv, uu - vv);
    return {{s(0) / n, s(1) / n}, {std::cos(angle), std::sin(angle)}};
  }

  bool fits(Run run) const {
    const auto [centre, direction] = fit(run);
    for (int i = run.first; i <= run.second; ++i) {
      const Eigen::Vector2d from = points_[i] - centre;
      if (std::abs(direction.x() * from.y() - direction.y() * from.x()) > p_.tolerance)
        return false;
    }
    return true;
  }

  int farthest_from_chord(Run run) const {
    const Eigen::Vector2d chord = points_[run.second] - points_[run.first];
    double largest = -1.0;
    int at = (run.first + run.second) / 2;
    for (int i = run.first + 1; i < run.second; ++i) {
      const Eigen::Vector2d from = points_[i] - points_[run.first];
      const double off = std::abs(chord.x() * from.y() - chord.y() * from.x());
      if (off > largest) {
        largest = off;
        at = i;
      }
    }
    return at;
  }

  LineParameters p_;
  std::vector<int> columns_;
  std::vector<Eigen::Vector2d> points_;
  std::vector<Sums> sums_;  // of the points before each, so that any run is fitted at once
};

}  // namespace

std::vector<Segment> find_segments(const double* uv, int count, int row, const LineParameters& p) {
  const Line line(uv, count, p);
  std::vector<Segment> found;
  for (const Run& run : line.runs()) {
    std::vector<Run> parts;
    line.split(run, &parts);
    Segment segment;
    for (const Run& part : line.joined(parts))
      if (line.segment(part, row, &segment)) found.push_back(segment);
  }
  return found;
}

}  // namespace safe_passage::scan_segmentation
