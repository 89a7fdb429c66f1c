#include "safe_passage/person_detection/clustering.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace safe_passage::person_detection {
namespace {

class UnionFind {
 public:
  explicit UnionFind(std::size_t size) : parent_(size) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  int find(int i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void unite(int a, int b) { parent_[find(a)] = find(b); }

 private:
  std::vector<int> parent_;
};

// Points sorted into cubes whose edge is the tolerance: a point's neighbours lie in 27 cubes.
class CubeIndex {
 public:
  CubeIndex(const Points& points, float edge) : next_(points.size()), cube_(points.size()) {
    Eigen::AlignedBox3f box;
    for (const auto& p : points) box.extend(p);
    const Eigen::Vector3f origin = box.min() - Eigen::Vector3f::Constant(edge);
    size_ =
        ((box.sizes() / edge).array().floor().cast<int>() + 3).matrix();  // a rim of empty cubes
    first_.assign(static_cast<std::size_t>(size_.x()) * size_.y() * size_.z(), -1);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector3i c = ((points[i] - origin) / edge).cast<int>();
      cube_[i] = (c.x() * size_.y() + c.y()) * size_.z() + c.z();
      next_[i] = first_[cube_[i]];
      first_[cube_[i]] = static_cast<int>(i);
    }
  }

  // Offsets to 13 of the 26 neighbours: the other 13 see the same pairs from the other side.
  std::vector<int> half_neighbourhood() const {
    std::vector<int> offsets;
    for (int dx = -1; dx <= 1; ++dx)
      for (int dy = -1; dy <= 1; ++dy)
        for (int dz = -1; dz <= 1; ++dz) {
          const int offset = (dx * size_.y() + dy) * size_.z() + dz;
          if (offset > 0) offsets.push_back(offset);
        }
    return offsets;
  }

  int cube(int point) const { return cube_[point]; }
  int first(int cube) const { return first_[cube]; }
  int next(int point) const { return next_[point]; }

 private:
  Eigen::Vector3i size_;
  std::vector<int> first_, next_, cube_;
};

// Highest point a cell of 0.06 m of the floor.
class HeightMap {
 public:
  static constexpr float kCell = 0.06F;

  HeightMap(const Points& points, float margin) {
    Eigen::AlignedBox2f box;
    for (const auto& p : points) box.extend(p.head<2>());
    origin_ = box.min() - Eigen::Vector2f::Constant(margin + kCell);
    const Eigen::Vector2f extent = box.sizes() + Eigen::Vector2f::Constant(2.0F * (margin + kCell));
    columns_ = static_cast<int>(extent.x() / kCell) + 1;
    rows_ = static_cast<int>(extent.y() / kCell) + 1;
    top_.assign(static_cast<std::size_t>(columns_) * rows_, -1);
    for (std::size_t i = 0; i < points.size(); ++i) {
      int& top = top_[cell(points[i])];
      if (top < 0 || points[i].z() > points[top].z()) top = static_cast<int>(i);
    }
  }

  std::size_t cell(const Eigen::Vector3f& p) const {
    const auto column = static_cast<std::size_t>((p.x() - origin_.x()) / kCell);
    const auto row = static_cast<std::size_t>((p.y() - origin_.y()) / kCell);
    return row * columns_ + column;
  }

  // Calls visit(point index) for the top of every occupied cell whose top lies within `radius`.
  template <typename Visit>
  void around(const Points& points, const Eigen::Vector3f& centre, float radius,
              Visit visit) const {
    const int reach = static_cast<int>(radius / kCell) + 1;
    const auto middle = static_cast<int>(cell(centre));
    for (int dy = -reach; dy <= reach; ++dy)
      for (int dx = -reach; dx <= reach; ++dx) {
        const int at = middle + dy * columns_ + dx;
        if (at < 0 || at >= static_cast<int>(top_.size()) || top_[at] < 0) continue;
        if ((points[top_[at]] - centre).head<2>().norm() <= radius) visit(top_[at]);
      }
  }

  const std::vector<int>& tops() const { return top_; }

 private:
  Eigen::Vector2f origin_;
  int columns_, rows_;
  std::vector<int> top_;  // index of the highest point, -1: none
};

bool is_peak(const HeightMap& map, const Points& points, int top, float radius) {
  bool peak = true;
  map.around(points, points[top], radius, [&](int other) {
    const float higher = points[other].z() - points[top].z();
    if (higher > 0.0F || (higher == 0.0F && other < top)) peak = false;
  });
  return peak;
}

// Around a head the shoulders are lower and the space is empty; along a wall or a shelf it is not.
float headness(const HeightMap& map, const Points& points, const Eigen::Vector3f& head) {
  constexpr int kSectors = 12;
  constexpr float kInner = 0.24F, kOuter = 0.42F, kDrop = 0.12F;  // [m]
  std::array<bool, kSectors> lower;
  lower.fill(true);
  map.around(points, head, kOuter, [&](int other) {
    const Eigen::Vector3f d = points[other] - head;
    if (d.head<2>().norm() < kInner || d.z() < -kDrop) return;
    const double turn = std::atan2(d.y(), d.x()) / (2.0 * M_PI) + 0.5;
    lower[std::min(kSectors - 1, static_cast<int>(turn * kSectors))] = false;
  });
  return static_cast<float>(std::count(lower.begin(), lower.end(), true)) / kSectors;
}

Candidate make_candidate(const Points& points, Indices body, int head) {
  Candidate candidate;
  candidate.head = points[head];
  Eigen::AlignedBox3f box;
  for (const int i : body) box.extend(points[i]);
  candidate.low = box.min();
  candidate.high = box.max();
  candidate.points = std::move(body);
  return candidate;
}

// The peaks of one cluster, and to each the cluster's points that are nearest to it.
std::vector<std::pair<int, Indices>> bodies(const Points& points, const Indices& cluster,
                                            const Indices& heads, float radius) {
  std::vector<std::pair<int, Indices>> bodies;
  for (const int head : heads) bodies.emplace_back(head, Indices{});
  for (const int i : cluster) {
    float least = radius * radius;
    Indices* body = nullptr;
    for (auto& [head, indices] : bodies) {
      const float distance = (points[head] - points[i]).head<2>().squaredNorm();
      if (distance <= least) {
        least = distance;
        body = &indices;
      }
    }
    if (body) body->push_back(i);
  }
  return bodies;
}

}  // namespace

Points above_ground(const Points& voxels, const GroundPlane& ground,
                    const ClusterParameters& parameters) {
  const GroundFrame frame(ground);
  Points above;
  above.reserve(voxels.size());
  for (const auto& voxel : voxels) {
    const Eigen::Vector3f p = frame.to_ground(voxel);
    if (p.z() > parameters.min_above_ground && p.z() < parameters.max_above_ground &&
        p.head<2>().norm() < 100.0F)
      above.push_back(p);
  }
  return above;
}

std::vector<Indices> euclidean_clusters(const Points& points, const ClusterParameters& parameters) {
  if (points.empty()) return {};
  const auto tolerance = static_cast<float>(parameters.tolerance);
  const CubeIndex cubes(points, tolerance);
  const auto neighbours = cubes.half_neighbourhood();
  UnionFind sets(points.size());
  const auto join_with = [&](int i, int other) {
    for (; other >= 0; other = cubes.next(other))
      if ((points[i] - points[other]).squaredNorm() <= tolerance * tolerance) sets.unite(i, other);
  };
  for (int i = 0; i < static_cast<int>(points.size()); ++i) {
    join_with(i, cubes.next(i));  // the rest of its own cube
    for (const int offset : neighbours) join_with(i, cubes.first(cubes.cube(i) + offset));
  }
  std::vector<Indices> by_root(points.size());
  for (int i = 0; i < static_cast<int>(points.size()); ++i) by_root[sets.find(i)].push_back(i);
  std::vector<Indices> clusters;
  for (auto& cluster : by_root)
    if (static_cast<int>(cluster.size()) >= parameters.min_points)
      clusters.push_back(std::move(cluster));
  return clusters;
}

std::vector<Candidate> head_subclusters(const Points& points, const std::vector<Indices>& clusters,
                                        const HeadParameters& parameters) {
  std::vector<Candidate> candidates;
  for (const Indices& cluster : clusters) {
    Points members;
    members.reserve(cluster.size());
    for (const int i : cluster) members.push_back(points[i]);
    const HeightMap map(members, static_cast<float>(parameters.body_radius));
    Indices heads;
    for (const int top : map.tops())
      if (top >= 0 && members[top].z() >= parameters.min_height &&
          members[top].z() <= parameters.max_height &&
          is_peak(map, members, top, static_cast<float>(parameters.head_distance)))
        heads.push_back(cluster[top]);
    for (auto& [head, body] :
         bodies(points, cluster, heads, static_cast<float>(parameters.body_radius))) {
      Candidate candidate = make_candidate(points, std::move(body), head);
      if (static_cast<int>(candidate.points.size()) < parameters.min_points) continue;
      if (candidate.high.z() - candidate.low.z() < parameters.min_extent) continue;
      candidate.headness = headness(map, members, points[head]);
      candidates.push_back(std::move(candidate));
    }
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const auto& a, const auto& b) { return a.headness > b.headness; });
  if (static_cast<int>(candidates.size()) > parameters.max_candidates)
    candidates.resize(parameters.max_candidates);
  return candidates;
}

}  // namespace safe_passage::person_detection
