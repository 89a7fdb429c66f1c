#include "safe_passage/scan_segmentation/maps.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace safe_passage::scan_segmentation {
namespace {

struct Corner {
  double x, y, z;
};

bool near(const Corner& a, const Corner& b, double gap, double step) {
  const double along = std::hypot(a.x - b.x, a.y - b.y);
  return along <= gap && std::abs(a.z - b.z) <= along + step;  // steeper than 45 degrees is a step
}

void draw(const Corner& a, const Corner& b, const Corner& c, std::uint8_t value, Bytes map) {
  const double turn = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
  if (turn == 0.0) return;
  const Corner &p = a, &q = turn > 0.0 ? b : c, &r = turn > 0.0 ? c : b;
  const int top = std::max(0, static_cast<int>(std::ceil(std::min({a.y, b.y, c.y}) - 0.5)));
  const int bottom =
      std::min(map.rows - 1, static_cast<int>(std::floor(std::max({a.y, b.y, c.y}) - 0.5)));
  for (int row = top; row <= bottom; ++row) {
    const double y = row + 0.5;
    double low = -1e9, high = 1e9;
    const Corner* corners[] = {&p, &q, &r, &p};
    bool empty = false;
    for (int e = 0; e < 3; ++e) {  // inside is to the left of each edge
      const Corner &s = *corners[e], &t = *corners[e + 1];
      const double dy = t.y - s.y;
      if (dy == 0.0) {
        if ((t.x - s.x) * (y - s.y) < 0.0) empty = true;
        continue;
      }
      const double x = s.x + (y - s.y) * (t.x - s.x) / dy;
      if (dy > 0.0)
        high = std::min(high, x);
      else
        low = std::max(low, x);
    }
    if (empty) continue;
    const int first = std::max(0, static_cast<int>(std::ceil(low - 0.5)));
    const int last = std::min(map.columns - 1, static_cast<int>(std::floor(high - 0.5)));
    std::uint8_t* cells = map.cell + static_cast<std::size_t>(row) * map.columns;
    for (int column = first; column <= last; ++column)
      if (cells[column] != kCovered) cells[column] = value;
  }
}

struct Span {
  int row, first, last;
};

std::vector<Span> box_spans(double angle, double half_length, double half_width) {
  const double c = std::cos(angle), s = std::sin(angle);
  const int reach =
      static_cast<int>(std::ceil(std::abs(s) * half_length + std::abs(c) * half_width));
  std::vector<Span> spans;
  for (int row = -reach; row <= reach; ++row) {
    double low = -1e9, high = 1e9;
    bool empty = false;
    const auto bound = [&](double factor, double offset, double half) {
      if (std::abs(factor) < 1e-12) {
        empty |= std::abs(offset) > half;
        return;
      }
      const double a = (-half - offset) / factor, b = (half - offset) / factor;
      low = std::max(low, std::min(a, b));
      high = std::min(high, std::max(a, b));
    };
    bound(c, s * row, half_length);
    bound(-s, c * row, half_width);
    const int first = static_cast<int>(std::ceil(low - 1e-9));
    const int last = static_cast<int>(std::floor(high + 1e-9));
    if (!empty && first <= last) spans.push_back({row, first, last});
  }
  // what is in the way is more often found in the first and last rows than in the middle
  std::sort(spans.begin(), spans.end(),
            [](const Span& a, const Span& b) { return std::abs(a.row) > std::abs(b.row); });
  return spans;
}

}  // namespace

void draw_ground(const double* xyz, const std::uint8_t* vertex, int height, int width, bool closed,
                 double gap, double step, Bytes map) {
  const auto triangle = [&](std::size_t i, std::size_t j, std::size_t k) {
    if (!vertex[i] || !vertex[j] || !vertex[k]) return;
    const int ground = (vertex[i] == kGround) + (vertex[j] == kGround) + (vertex[k] == kGround);
    if (ground == 0) return;
    const auto corner = [&](std::size_t at) {
      return Corner{xyz[3 * at], xyz[3 * at + 1], xyz[3 * at + 2]};
    };
    const Corner a = corner(i), b = corner(j), c = corner(k);
    const double steep = ground == 3 ? step : 1e9;
    if (!near(a, b, gap, steep) || !near(b, c, gap, steep) || !near(c, a, gap, steep)) return;
    draw(a, b, c, ground == 3 ? kCovered : kBeside, map);
  };
  for (int line = 0; line < height; ++line) {
    if (line + 1 == height && !closed) break;
    const std::size_t here = static_cast<std::size_t>(line) * width,
                      next = static_cast<std::size_t>((line + 1) % height) * width;
    for (int i = 0; i + 1 < width; ++i) {
      triangle(here + i, here + i + 1, next + i);
      triangle(here + i + 1, next + i + 1, next + i);
    }
  }
}

void draw_rays(const double* from, const double* to, int count, Bytes map) {
  for (int ray = 0; ray < count; ++ray) {
    const double* a = from + 2 * ray;
    const double* b = to + 2 * ray;
    const double length = std::hypot(b[0] - a[0], b[1] - a[1]);
    if (!(length < 1e6)) continue;
    const int steps = static_cast<int>(std::ceil(length));
    const double dx = steps ? (b[0] - a[0]) / steps : 0.0, dy = steps ? (b[1] - a[1]) / steps : 0.0;
    for (int i = 0; i <= steps; ++i) {
      const int column = static_cast<int>(std::floor(a[0] + i * dx)),
                row = static_cast<int>(std::floor(a[1] + i * dy));
      if (row >= 0 && row < map.rows && column >= 0 && column < map.columns)
        map.cell[static_cast<std::size_t>(row) * map.columns + column] = 1;
    }
  }
}

std::vector<int> fit_box(Bytes blocked, const std::vector<int>& cells,
                         const std::vector<double>& angles, const std::vector<double>& half_length,
                         const std::vector<double>& half_width) {
  const int stride = blocked.columns + 1;
  std::vector<std::int32_t> before(static_cast<std::size_t>(blocked.rows) * stride, 0);
  for (int row = 0; row < blocked.rows; ++row) {
    const std::uint8_t* in = blocked.cell + static_cast<std::size_t>(row) * blocked.columns;
    std::int32_t* out = before.data() + static_cast<std::size_t>(row) * stride;
    for (int column = 0; column < blocked.columns; ++column)
      out[column + 1] = out[column] + (in[column] != 0);
  }
  std::vector<std::vector<Span>> boxes;
  for (std::size_t i = 0; i < angles.size(); ++i)
    boxes.push_back(box_spans(angles[i], half_length[i], half_width[i]));
  const auto fits = [&](const std::vector<Span>& box, int row, int column) {
    for (const Span& span : box) {
      const int y = row + span.row, first = column + span.first, last = column + span.last;
      if (y < 0 || y >= blocked.rows || first < 0 || last >= blocked.columns) return false;
      const std::int32_t* line = before.data() + static_cast<std::size_t>(y) * stride;
      if (line[last + 1] != line[first]) return false;
    }
    return true;
  };
  std::vector<int> order(angles.size()), found(cells.size() / 2, -1);
  std::iota(order.begin(), order.end(), 0);
  for (std::size_t i = 0; i < found.size(); ++i)
    for (std::size_t k = 0; k < order.size(); ++k) {
      if (!fits(boxes[order[k]], cells[2 * i], cells[2 * i + 1])) continue;
      found[i] = order[k];
      std::rotate(order.begin(), order.begin() + k, order.begin() + k + 1);  // likely the next's
      break;
    }
  return found;
}

}  // namespace safe_passage::scan_segmentation
