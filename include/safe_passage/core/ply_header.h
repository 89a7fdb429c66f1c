// Headers of PLY files that lie: PCL reserves what a header tells of before it reads a point.
#pragma once

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <system_error>

namespace safe_passage {

// Throws std::runtime_error, naming the file, where its header tells of more points than a file of
// its size can hold, or of a number of them that is none.
inline void refuse_lying_ply(const std::string& path) {
  constexpr int kMostLines = 200;             // of a header
  constexpr std::size_t kLongestLine = 4096;  // what is longer is no header
  std::ifstream file(path, std::ios::binary);
  if (!file) return;  // the reader says it
  double elements = 0.0;
  std::string text(kLongestLine, '\0');
  for (int i = 0; i < kMostLines && file.getline(text.data(), static_cast<int>(kLongestLine));
       ++i) {
    std::istringstream line(text.c_str());
    std::string key;
    line >> key;
    double number = 0.0;
    if (key == "element") {
      if (!(line >> key >> number) || number < 0.0)  // PCL takes -3 as 2^32 - 3
        throw std::runtime_error(path + ": its header has an element without a number");
      elements += number;
    }
    if (key == "end_header") break;
  }
  std::error_code unknown;  // no element is smaller than a byte
  const auto size = static_cast<double>(std::filesystem::file_size(path, unknown));
  if (!unknown && elements > size)
    throw std::runtime_error(path + ": its header tells of more points than the file can hold");
}

}  // namespace safe_passage
