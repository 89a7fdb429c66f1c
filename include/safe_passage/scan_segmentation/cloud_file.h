// Point clouds of PCD and PLY files, by PCL.
#pragma once

#include <string>
#include <vector>

namespace safe_passage::scan_segmentation {

struct CloudFile {
  int width, height;
  std::vector<double> xyz;        // [m] three of each point
  std::vector<double> remission;  // of each point, empty: the file has none
  double origin[3];               // [m] of the scanner
};

// Throws std::runtime_error naming the file and what is wrong with it.
CloudFile read_cloud(const std::string& path);

}  // namespace safe_passage::scan_segmentation
