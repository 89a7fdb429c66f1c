#include "safe_passage/person_detection/voxel_grid.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace safe_passage::person_detection {
namespace {

constexpr std::uint64_t kNoKey = ~std::uint64_t{0};
constexpr int kHalfAxis = 1 << 20;  // 21 bits an axis

std::uint64_t key_of(const Eigen::Vector3f& p, float inverse_leaf) {
  const auto axis = [inverse_leaf](float v) {
    const float cell = v * inverse_leaf;
    const int truncated = static_cast<int>(cell);  // std::floor is a call without SSE 4.1
    return static_cast<std::uint64_t>(truncated - (cell < static_cast<float>(truncated)) +
                                      kHalfAxis);
  };
  return axis(p.x()) << 42 | axis(p.y()) << 21 | axis(p.z());
}

std::size_t hash(std::uint64_t key) { return key * 0x9E3779B97F4A7C15ULL >> 32; }

}  // namespace

VoxelGrid::VoxelGrid(const VoxelParameters& parameters) : parameters_(parameters) {
  slots_.resize(1 << 16, Slot{0, 0, 0});
}

int VoxelGrid::step(double focal) const {
  if (parameters_.sampling > 0) return parameters_.sampling;
  const double pixels_a_voxel = parameters_.leaf * focal / parameters_.max_range;
  return std::max(1, static_cast<int>(pixels_a_voxel / 1.5));
}

Points VoxelGrid::filter(const cv::Mat& xyz, double focal) {
  if (xyz.type() != CV_32FC3) throw std::invalid_argument("voxel grid: xyz must be CV_32FC3");
  ++frame_;
  cells_.clear();
  keys_.clear();
  const auto inverse_leaf = static_cast<float>(1.0 / parameters_.leaf);
  const auto max_range = static_cast<float>(parameters_.max_range);
  std::uint64_t last_key = kNoKey;  // neighbours in a row mostly share a voxel
  int last_cell = -1;
  const int step = this->step(focal);
  for (int row = 0; row < xyz.rows; row += step) {
    const auto* pixels = xyz.ptr<Eigen::Vector3f>(row);
    for (int column = 0; column < xyz.cols; column += step) {
      const Eigen::Vector3f& p = pixels[column];
      // Written so that NaN fails; x and y are bounded by any camera's field of view.
      if (!(p.z() > 0.0F && p.z() <= max_range)) continue;
      if (!(std::abs(p.x()) < 1e3F && std::abs(p.y()) < 1e3F)) continue;
      const std::uint64_t key = key_of(p, inverse_leaf);
      if (key != last_key) {
        last_key = key;
        last_cell = find_or_add(key);
      }
      cells_[last_cell].sum += p;
      ++cells_[last_cell].count;
    }
  }
  Points centroids;
  centroids.reserve(cells_.size());
  for (const Cell& cell : cells_) centroids.push_back(cell.sum / static_cast<float>(cell.count));
  return centroids;
}

int VoxelGrid::find_or_add(std::uint64_t key) {
  if (2 * cells_.size() > slots_.size()) grow();
  const std::size_t mask = slots_.size() - 1;
  std::size_t i = hash(key) & mask;
  while (slots_[i].frame == frame_) {
    if (slots_[i].key == key) return slots_[i].cell;
    i = (i + 1) & mask;
  }
  slots_[i] = {key, frame_, static_cast<std::int32_t>(cells_.size())};
  cells_.push_back({Eigen::Vector3f::Zero(), 0});
  keys_.push_back(key);
  return slots_[i].cell;
}

void VoxelGrid::grow() {
  slots_.assign(2 * slots_.size(), Slot{0, frame_ - 1, 0});
  const std::size_t mask = slots_.size() - 1;
  for (std::size_t cell = 0; cell < keys_.size(); ++cell) {
    std::size_t i = hash(keys_[cell]) & mask;
    while (slots_[i].frame == frame_) i = (i + 1) & mask;
    slots_[i] = {keys_[cell], frame_, static_cast<std::int32_t>(cell)};
  }
}

}  // namespace safe_passage::person_detection
