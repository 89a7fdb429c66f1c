#include "safe_passage/scan_segmentation/clusters.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace safe_passage::scan_segmentation {
namespace {

constexpr int kMissing = 3;         // lines in a row that a growing cluster may skip
constexpr int kRounds = 3;          // in which segments join and the plane is fitted again
constexpr double kSpread = 0.03;    // [m] that points reach to the side: less is a line, no plane
constexpr double kAlongSine = 0.2;  // of the angle between a segment and its plane, at most

std::optional<Plane> fit(const Moments& m) {
  if (m.n < 10.0) return std::nullopt;
  const Eigen::Vector3d centre = m.sum / m.n;
  const Eigen::Matrix3d covariance = m.squares / m.n - centre * centre.transpose();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(covariance);
  if (!(solver.eigenvalues()(1) > kSpread * kSpread)) return std::nullopt;
  Plane plane;
  plane.normal = solver.eigenvectors().col(0);
  plane.offset = -plane.normal.dot(centre);
  if (plane.offset < 0.0) {
    plane.normal = -plane.normal;
    plane.offset = -plane.offset;
  }
  plane.rms = std::sqrt(std::max(solver.eigenvalues()(0), 0.0));
  plane.moments = m;
  return plane;
}

double to_segment(const Eigen::Vector3d& point, const Line3d& line) {
  const Eigen::Vector3d along = line.end - line.start;
  const double share = std::clamp((point - line.start).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (point - line.start - share * along).norm();
}

class Growth {
 public:
  Growth(const std::vector<Line3d>& lines, int rows, const ClusterParameters& p)
      : lines_(lines), rows_(rows), p_(p), start_(rows + 1, 0), owner_(lines.size(), -1) {
    for (const Line3d& line : lines) ++start_[line.row + 1];
    for (int row = 0; row < rows; ++row) start_[row + 1] += start_[row];
  }

  Clusters run() {
    Clusters found;
    for (int seed = 0; seed < static_cast<int>(lines_.size()); ++seed) {
      if (owner_[seed] >= 0) continue;
      const int number = static_cast<int>(found.planes.size());
      if (auto plane = grow(seed, number)) found.planes.push_back(*plane);
    }
    found.plane = std::move(owner_);
    return found;
  }

 private:
  std::optional<Plane> grow(int seed, int number) {
    members_.assign(1, seed);
    moments_ = lines_[seed].moments;
    plane_.reset();
    next_fit_ = p_.first_fit;
    follow(seed);
    const bool enough = plane_ && static_cast<int>(members_.size()) >= p_.plane_segments;
    if (!enough) return std::nullopt;
    for (int round = 0; round < kRounds; ++round) {  // a better plane reaches segments passed over
      gather(seed);
      if (!settle()) return std::nullopt;
    }
    for (int i : members_) owner_[i] = number;
    return plane_;
  }

  // From line to line, as long as each joins the last.
  void follow(int seed) {
    int last = seed, missing = 0;
    for (int step = 1; step < rows_ && missing < kMissing; ++step) {
      const int row = row_after(lines_[seed].row, step);
      if (row < 0 || static_cast<int>(members_.size()) >= p_.plane_segments) break;
      const int next = best_in(row, last);
      missing = next < 0 ? missing + 1 : 0;
      if (next < 0) continue;
      join(next);
      last = next;
    }
  }

  // The rest of the segments, held against the equation alone.
  void gather(int seed) {
    std::vector<char> in(lines_.size(), 0);
    for (int i : members_) in[i] = 1;
    for (int step = 0; step < rows_; ++step) {
      const int row = (lines_[seed].row + step) % rows_;
      for (int i = start_[row]; i < start_[row + 1]; ++i)
        if (owner_[i] < 0 && !in[i] && lies_in(lines_[i], *plane_)) join(i);
    }
  }

  // The last fit; whoever no longer lies in it leaves.
  bool settle() {
    for (int round = 0; round < 2; ++round) {
      plane_ = fit(moments_);
      if (!plane_) return false;
      moments_ = Moments();
      std::vector<int> kept;
      for (int i : members_)
        if (lies_in(lines_[i], *plane_)) {
          kept.push_back(i);
          moments_ += lines_[i].moments;
        }
      members_ = std::move(kept);
    }
    plane_ = fit(moments_);
    return plane_ && plane_->rms < 0.5 * p_.tolerance &&
           static_cast<int>(members_.size()) >= p_.plane_segments;
  }

  void join(int i) {
    members_.push_back(i);
    moments_ += lines_[i].moments;
    const int count = static_cast<int>(members_.size());
    if (count < next_fit_) return;
    if (auto better = fit(moments_)) plane_ = better;
    next_fit_ = count + std::min(count, p_.refit_every);
  }

  int best_in(int row, int last) const {
    int best = -1;
    double least = std::numeric_limits<double>::infinity();
    for (int i = start_[row]; i < start_[row + 1]; ++i) {
      if (owner_[i] >= 0) continue;
      const double distance = plane_ ? near_in_plane(i, last) : similar(i, last);
      if (distance < least) {
        least = distance;
        best = i;
      }
    }
    return best;
  }

  double allowed(int i) const {
    const double range = std::max(lines_[i].start.norm(), lines_[i].end.norm());
    return p_.similar_distance + 1.5 * p_.line_spacing * range;
  }

  // [m] by which end points differ, inf: not similar.
  double similar(int i, int last) const {
    const Line3d &a = lines_[i], &b = lines_[last];
    const double start = (a.start - b.start).norm(), end = (a.end - b.end).norm();
    const double most = allowed(i);
    const Eigen::Vector3d m = (a.end - a.start).normalized(), n = (b.end - b.start).normalized();
    const double angle = std::acos(std::clamp(m.dot(n), -1.0, 1.0));
    if (start > most || end > most || angle > p_.similar_angle)
      return std::numeric_limits<double>::infinity();
    return start + end;
  }

  double near_in_plane(int i, int last) const {
    const double far = std::numeric_limits<double>::infinity();
    if (!lies_in(lines_[i], *plane_)) return far;
    const Line3d &a = lines_[i], &b = lines_[last];
    const double distance = std::min({to_segment(a.start, b), to_segment(a.end, b),
                                      to_segment(b.start, a), to_segment(b.end, a)});
    return distance < allowed(i) ? distance : far;
  }

  bool lies_in(const Line3d& line, const Plane& plane) const {
    const double start = plane.normal.dot(line.start) + plane.offset;
    const double end = plane.normal.dot(line.end) + plane.offset;
    if (std::abs(start) > p_.tolerance || std::abs(end) > p_.tolerance) return false;
    return std::abs(end - start) <= kAlongSine * (line.end - line.start).norm();
  }

  int row_after(int row, int step) const {
    if (row + step < rows_) return row + step;
    return p_.closed ? row + step - rows_ : -1;
  }

  const std::vector<Line3d>& lines_;
  int rows_;
  ClusterParameters p_;
  std::vector<int> start_, owner_, members_;
  Moments moments_;
  std::optional<Plane> plane_;
  int next_fit_ = 0;
};

bool is_same(const Plane& a, const Plane& b, const ClusterParameters& p) {
  if (std::abs(a.normal.dot(b.normal)) < std::cos(p.merge_angle)) return false;
  const Eigen::Vector3d ca = a.moments.sum / a.moments.n, cb = b.moments.sum / b.moments.n;
  return std::abs(a.normal.dot(cb) + a.offset) < p.tolerance &&
         std::abs(b.normal.dot(ca) + b.offset) < p.tolerance;
}

void merge(Clusters* clusters, const ClusterParameters& p) {
  std::vector<Plane>& planes = clusters->planes;
  for (std::size_t i = 0; i < planes.size(); ++i)
    for (std::size_t k = planes.size(); --k > i;) {
      if (!is_same(planes[i], planes[k], p)) continue;
      Moments both = planes[i].moments;
      both += planes[k].moments;
      const auto one = fit(both);
      if (!one || one->rms > 0.5 * p.tolerance) continue;
      planes[i] = *one;
      planes.erase(planes.begin() + static_cast<long>(k));
      for (int& owner : clusters->plane) {
        if (owner == static_cast<int>(k))
          owner = static_cast<int>(i);
        else if (owner > static_cast<int>(k))
          --owner;
      }
    }
}

}  // namespace

void Moments::add(const Eigen::Vector3d& point) {
  n += 1.0;
  sum += point;
  squares += point * point.transpose();
}

void Moments::operator+=(const Moments& other) {
  n += other.n;
  sum += other.sum;
  squares += other.squares;
}

Clusters cluster(const std::vector<Line3d>& lines, int rows, const ClusterParameters& p) {
  Clusters found = Growth(lines, rows, p).run();
  merge(&found, p);
  return found;
}

}  // namespace safe_passage::scan_segmentation
