// Headers of PCD and PLY files that lie: PCL reserves what a header tells of before it reads a point.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>

namespace safe_passage {

// Throws std::runtime_error, naming the file, where its header tells of more points, or larger ones,
// than a file of its size can hold.
inline void refuse_lying_header(const std::string& path) {
  constexpr double kMostBytesAByte = 100.0;   // compressed zeros: 88
  constexpr int kMostLines = 200;             // of a header
  constexpr std::size_t kLongestLine = 4096;  // what is longer is no header
  std::ifstream file(path, std::ios::binary);
  if (!file) return;  // the reader says it
  double points = 0.0, width = 0.0, height = 1.0, elements = 0.0;
  double point_bytes = 1.0, sizes = 0.0;
  std::string text(kLongestLine, '\0');
  for (int i = 0; i < kMostLines && file.getline(text.data(), static_cast<int>(kLongestLine));
       ++i) {
    std::istringstream line(text.c_str());
    std::string key;
    line >> key;
    double number = 0.0;
    if (key == "WIDTH") line >> width;
    if (key == "HEIGHT") line >> height;
    if (key == "POINTS") line >> points;
    if (key == "SIZE")
      while (line >> number) sizes += std::abs(number);
    if (key == "COUNT")
      while (line >> number) point_bytes = std::max(point_bytes, std::abs(number));
    if (key == "element" && line >> key && line >> number) elements += std::abs(number);
    if (key == "DATA" || key == "end_header") break;
  }
  const double told = std::max({std::abs(points), std::abs(width * height), elements});
  const double bytes = told * std::max(1.0, sizes) * point_bytes;
  std::error_code unknown;
  const auto size = static_cast<double>(std::filesystem::file_size(path, unknown));
  if (!unknown && bytes > kMostBytesAByte * std::max(size, 1.0))
    throw std::runtime_error(path + ": its header tells of more points than the file can hold");
}

}  // namespace safe_passage
