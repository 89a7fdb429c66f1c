// PCD files, checked before PCL reads them. PCL 1.13 believes a header line by line: the memory of the
// points is reserved at POINTS, and written by what FIELDS, SIZE, TYPE and COUNT say last, so that a
// header which contradicts itself makes it write past its memory. The format has one order of lines.
#pragma once

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <locale>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace safe_passage {
namespace pcd {

using Words = std::vector<std::string>;
using Lines = std::map<std::string, Words>;  // of a header: what follows each key

constexpr std::array<const char*, 10> kKeys = {"VERSION", "FIELDS", "SIZE",      "TYPE",   "COUNT",
                                               "WIDTH",   "HEIGHT", "VIEWPOINT", "POINTS", "DATA"};
constexpr double kMostBytes = 2147483647.0;  // PCL counts them in int
constexpr double kMostBytesAByte = 100.0;    // compressed zeros: 88

struct Layout {
  double bytes = 0.0;  // of all points
  std::uint32_t points = 0, values = 0;
  bool padded = false;  // has fields without a name
};

// A word as a message can show it.
inline std::string shown(std::string word) {
  for (char& c : word)
    if (c < ' ' || c > '~') c = '?';  // of a file that is none python could not decode it
  return word.substr(0, 40);
}

inline Words words_of(const std::string& line) {
  std::istringstream stream(line);
  stream.imbue(std::locale::classic());
  Words words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

// The lines up to DATA, where the file then stands.
inline Lines header_of(std::istream& file) {
  std::string text(4096, '\0');  // what is longer is no header
  Lines lines;
  auto expected = kKeys.begin();
  while (file.getline(text.data(), static_cast<std::streamsize>(text.size()))) {
    const std::string line(text.data(), static_cast<std::size_t>(file.gcount()) - !file.eof());
    if (line.empty()) continue;
    const Words words = words_of(line);
    if (!words.empty() && words[0][0] == '#') continue;
    for (const char c : line)
      if (static_cast<unsigned char>(c) < ' ' && c != '\t' && c != '\r')
        throw std::runtime_error("its header is no text");
    const std::string key = words.empty() ? "" : words[0];
    expected = std::find(expected, kKeys.end(), key);
    if (expected == kKeys.end())
      throw std::runtime_error("its header has a line that is unknown or out of order: " +
                               shown(key));
    ++expected;
    lines[key] = Words(words.begin() + 1, words.end());
    if (key == "DATA" && !file.eof()) return lines;
  }
  throw std::runtime_error("its header does not end");
}

inline std::uint32_t number(const std::string& word) {
  std::uint32_t value = 0;
  const auto* end = word.data() + word.size();
  const auto read = std::from_chars(word.data(), end, value);
  if (read.ec != std::errc() || read.ptr != end)
    throw std::runtime_error("its header has a number that is none: " + shown(word));
  return value;
}

inline const Words& line_of(const Lines& lines, const std::string& key, std::size_t count) {
  const auto found = lines.find(key);
  if (found == lines.end() || found->second.size() != count || count == 0)
    throw std::runtime_error("its header's " + key + " lacks or has the wrong number of values");
  return found->second;
}

inline bool is_type(std::uint32_t size, const std::string& type) {
  if (type == "I" || type == "U") return size == 1 || size == 2 || size == 4 || size == 8;
  return type == "F" ? size == 4 || size == 8 : type == "B" && size == 1;
}

inline Layout layout_of(const Lines& lines) {
  const auto fields = lines.find("FIELDS");
  if (fields == lines.end()) throw std::runtime_error("its header tells of no FIELDS");
  const std::size_t count = fields->second.size();
  const Words& sizes = line_of(lines, "SIZE", count);
  const Words& types = line_of(lines, "TYPE", count);
  const Words counts = lines.count("COUNT") ? line_of(lines, "COUNT", count) : Words(count, "1");
  double step = 0.0, values = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    if (number(counts[i]) == 0 || !is_type(number(sizes[i]), types[i]))
      throw std::runtime_error("field " + shown(fields->second[i]) + " is of an unknown type");
    step += static_cast<double>(number(sizes[i])) * number(counts[i]);
    values += number(counts[i]);
  }
  Layout layout;
  layout.points = number(line_of(lines, "POINTS", 1)[0]);
  const double cells = static_cast<double>(number(line_of(lines, "WIDTH", 1)[0])) *
                       number(line_of(lines, "HEIGHT", 1)[0]);
  if (cells != layout.points) throw std::runtime_error("its POINTS are not WIDTH times HEIGHT");
  if (layout.points == 0) throw std::runtime_error("it has no points");
  layout.bytes = step * layout.points;
  if (layout.bytes > kMostBytes) throw std::runtime_error("too large");
  layout.values = static_cast<std::uint32_t>(values);
  const Words& names = fields->second;
  layout.padded = std::find(names.begin(), names.end(), "_") != names.end();
  return layout;
}

inline void check_viewpoint(const Lines& lines) {
  if (!lines.count("VIEWPOINT")) return;
  for (const std::string& word : line_of(lines, "VIEWPOINT", 7)) {
    std::istringstream stream(word);
    stream.imbue(std::locale::classic());
    float value = 0.0F;
    if (!(stream >> value) || !stream.eof() || !std::isfinite(value))
      throw std::runtime_error("its header has a number that is none: " + shown(word));
  }
}

// PCL 1.13.0 reads on behind DATA as long as lines are empty, comments or known to it, so that points
// which begin like a header's line would change the header. The file stands where it stood afterwards.
inline void refuse_second_header(std::istream& file) {
  const auto start = file.tellg();
  for (std::string line; std::getline(file, line);) {
    if (line.empty()) continue;
    const Words words = words_of(line);
    if (words.empty()) break;
    if (words[0][0] == '#') continue;
    const auto is_start = [&words](const char* key) { return words[0].rfind(key, 0) == 0; };
    if (is_start("COLUMNS") || std::any_of(kKeys.begin(), kKeys.end(), is_start))
      throw std::runtime_error("its points begin like a header");
    break;
  }
  file.clear();
  file.seekg(start);
}

// PCL makes zeros of a line that is too short or too long.
inline void check_text(std::istream& file, const Layout& layout) {
  std::uint32_t point = 0;
  for (std::string line; point < layout.points && std::getline(file, line);) {
    if (line.empty()) continue;
    std::uint32_t values = 0;
    bool blank = true;
    for (const char c : line) {
      const bool is_blank = c == ' ' || c == '\t' || c == '\r';
      values += blank && !is_blank;
      blank = is_blank;
    }
    ++point;
    if (values != layout.values)
      throw std::runtime_error("point " + std::to_string(point) + " has " + std::to_string(values) +
                               " values, not " + std::to_string(layout.values));
  }
  if (point < layout.points) throw std::runtime_error("it ends before its last point");
}

inline void check_compressed(std::istream& file, const Layout& layout, double left) {
  std::uint32_t packed = 0, unpacked = 0;
  char sizes[8] = {};
  if (!file.read(sizes, 8)) throw std::runtime_error("it ends before its points");
  std::memcpy(&packed, sizes, 4);
  std::memcpy(&unpacked, sizes + 4, 4);
  if (packed == 0 || packed > left - 8.0) throw std::runtime_error("it ends before its last point");
  if (unpacked != layout.bytes || layout.padded)  // PCL unpacks padding to where none was reserved
    throw std::runtime_error("its compressed points are not those its header tells of");
}

}  // namespace pcd

// Throws std::runtime_error, naming the file, if its header is not a sound one of the format (0.6 or
// 0.7), or tells of points that the file does not hold. A file that cannot be opened is passed over.
inline void refuse_unsound_pcd(const std::string& path) try {
  std::ifstream file(path, std::ios::binary);
  if (!file) return;  // the reader says it
  const pcd::Lines lines = pcd::header_of(file);
  const pcd::Layout layout = pcd::layout_of(lines);
  pcd::check_viewpoint(lines);
  const auto size = static_cast<double>(std::filesystem::file_size(path));
  if (layout.bytes > pcd::kMostBytesAByte * size)
    throw std::runtime_error("its header tells of more points than the file can hold");
  const std::string kind = pcd::line_of(lines, "DATA", 1)[0];
  const double left = size - static_cast<double>(file.tellg());
  pcd::refuse_second_header(file);
  if (kind == "ascii") {
    pcd::check_text(file, layout);
  } else if (kind == "binary_compressed") {
    pcd::check_compressed(file, layout, left);
  } else if (kind != "binary") {
    throw std::runtime_error("its DATA are of an unknown kind: " + pcd::shown(kind));
  } else if (layout.bytes > left) {
    throw std::runtime_error("it ends before its last point");
  }
} catch (const std::runtime_error& error) {
  throw std::runtime_error(path + ": " + error.what());
}

}  // namespace safe_passage
