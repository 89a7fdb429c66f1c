// Voxel filter (paper 002, section 2.2): one centroid a voxel of 0.06 m.
#pragma once

#include <cstdint>
#include <vector>

#include "safe_passage/person_detection/types.h"

namespace safe_passage::person_detection {

struct VoxelParameters {
  double leaf = 0.06;       // [m] edge of a voxel
  double max_range = 10.0;  // [m] along the optical axis; farther points are not looked at
  int sampling =
      0;  // every n-th pixel of every n-th row; 0: as far apart as leaves no gaps at max_range
};

// Keeps its table between frames: an allocation a frame would cost more than the filter.
class VoxelGrid {
 public:
  explicit VoxelGrid(const VoxelParameters& parameters);

  // Centroids of the occupied voxels, in the order of their first pixel. Points that are not finite
  // or not in front of the camera are left out. `focal` [px]: of the camera that made xyz.
  Points filter(const cv::Mat& xyz, double focal);

 private:
  struct Cell {
    Eigen::Vector3f sum;
    int count;
  };
  struct Slot {
    std::uint64_t key;
    std::uint32_t frame;  // the slot holds a cell of this frame, else it is free
    std::int32_t cell;
  };

  int step(double focal) const;
  int find_or_add(std::uint64_t key);
  void grow();

  VoxelParameters parameters_;
  std::vector<Slot> slots_;  // open addressing, size a power of two
  std::vector<Cell> cells_;
  std::vector<std::uint64_t> keys_;
  std::uint32_t frame_ = 0;
};

}  // namespace safe_passage::person_detection
