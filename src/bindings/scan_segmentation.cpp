// The scan segmentation's hot kernels for Python.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cmath>
#include <stdexcept>
#include <tuple>
#include <vector>

#include "safe_passage/scan_segmentation/cloud_file.h"
#include "safe_passage/scan_segmentation/clusters.h"
#include "safe_passage/scan_segmentation/lines.h"
#include "safe_passage/scan_segmentation/maps.h"

namespace py = pybind11;
using namespace safe_passage::scan_segmentation;
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Integers = py::array_t<std::int32_t, py::array::c_style | py::array::forcecast>;
using Map = py::array_t<std::uint8_t, py::array::c_style>;

namespace {

void check(bool fits, const char* what) {
  if (!fits) throw std::invalid_argument(what);
}

template <typename T>
py::array_t<T> table(const std::vector<T>& values, py::ssize_t columns) {
  py::array_t<T> out({static_cast<py::ssize_t>(values.size()) / columns, columns});
  std::copy(values.begin(), values.end(), out.mutable_data());
  return out;
}

// (S, 3) row, first, last and (S, 4) start and end.
std::tuple<py::array_t<int>, py::array_t<double>> find(const Doubles& uv, double tolerance,
                                                       int points, double length, double gap,
                                                       double gap_share) {
  check(uv.ndim() == 3 && uv.shape(2) == 2, "expected uv (H, W, 2)");
  const LineParameters p{tolerance, points, length, gap, gap_share};
  const int width = static_cast<int>(uv.shape(1));
  std::vector<int> where;
  std::vector<double> ends;
  for (int row = 0; row < uv.shape(0); ++row)
    for (const Segment& s :
         find_segments(uv.data() + static_cast<std::size_t>(row) * width * 2, width, row, p)) {
      where.insert(where.end(), {s.row, s.first, s.last});
      ends.insert(ends.end(), {s.start.x(), s.start.y(), s.end.x(), s.end.y()});
    }
  return {table(where, 3), table(ends, 4)};
}

// (S,) plane of each segment, -1: none, and (P, 5) normal, offset, rms.
std::tuple<py::array_t<int>, py::array_t<double>> cluster_segments(
    const Doubles& points, const Integers& where, const Doubles& ends, double similar_distance,
    double similar_angle, int first_fit, int refit_every, int plane_segments, double tolerance,
    double merge_angle, double line_spacing, bool closed) {
  check(points.ndim() == 3 && points.shape(2) == 3, "expected points (H, W, 3)");
  check(where.ndim() == 2 && where.shape(1) == 3, "expected where (S, 3)");
  check(ends.ndim() == 2 && ends.shape(1) == 6 && ends.shape(0) == where.shape(0),
        "expected ends (S, 6)");
  const auto at = points.unchecked<3>();
  const auto w = where.unchecked<2>();
  const auto e = ends.unchecked<2>();
  std::vector<Line3d> lines;
  for (py::ssize_t i = 0; i < where.shape(0); ++i) {
    check(w(i, 0) >= 0 && w(i, 0) < points.shape(0) && w(i, 1) >= 0 && w(i, 2) < points.shape(1) &&
              (i == 0 || w(i - 1, 0) <= w(i, 0)),
          "expected segments of these points, sorted by row");
    Line3d line{w(i, 0), {e(i, 0), e(i, 1), e(i, 2)}, {e(i, 3), e(i, 4), e(i, 5)}, {}};
    for (int k = w(i, 1); k <= w(i, 2); ++k) {
      const Eigen::Vector3d point(at(w(i, 0), k, 0), at(w(i, 0), k, 1), at(w(i, 0), k, 2));
      if (point.allFinite()) line.moments.add(point);
    }
    lines.push_back(line);
  }
  const Clusters found = cluster(lines, static_cast<int>(points.shape(0)),
                                 {similar_distance, similar_angle, first_fit, refit_every,
                                  plane_segments, tolerance, merge_angle, line_spacing, closed});
  std::vector<double> planes;
  for (const Plane& plane : found.planes)
    planes.insert(planes.end(),
                  {plane.normal.x(), plane.normal.y(), plane.normal.z(), plane.offset, plane.rms});
  py::array_t<int> owner(static_cast<py::ssize_t>(found.plane.size()));
  std::copy(found.plane.begin(), found.plane.end(), owner.mutable_data());
  return {owner, table(planes, 5)};
}

// Pairs (K, 2) of a plane and a point of it that is nearer than `tolerance`; of a point on a
// segment only planes that the segment runs along.
py::array_t<int> supporting(const Doubles& points, const Integers& segment,
                            const Doubles& directions, const Doubles& planes, double tolerance,
                            double along_sine) {
  check(points.ndim() == 2 && points.shape(1) == 3, "expected points (N, 3)");
  check(segment.ndim() == 1 && segment.size() == points.shape(0), "expected segments (N,)");
  check(directions.ndim() == 2 && directions.shape(1) == 3, "expected directions (S, 3)");
  check(planes.ndim() == 2 && planes.shape(1) == 4, "expected planes (P, 4)");
  const auto at = points.unchecked<2>(), plane = planes.unchecked<2>(),
             m = directions.unchecked<2>();
  const auto of = segment.unchecked<1>();
  const py::ssize_t count = planes.shape(0);
  std::vector<char> along(static_cast<std::size_t>(directions.shape(0) * count));
  for (py::ssize_t s = 0; s < directions.shape(0); ++s)
    for (py::ssize_t k = 0; k < count; ++k)
      along[s * count + k] = std::abs(m(s, 0) * plane(k, 0) + m(s, 1) * plane(k, 1) +
                                      m(s, 2) * plane(k, 2)) <= along_sine;
  std::vector<int> pairs;
  for (py::ssize_t i = 0; i < points.shape(0); ++i) {
    check(of(i) < directions.shape(0), "expected segments below S");
    for (py::ssize_t k = 0; k < count; ++k) {
      const double off =
          plane(k, 0) * at(i, 0) + plane(k, 1) * at(i, 1) + plane(k, 2) * at(i, 2) + plane(k, 3);
      if (std::abs(off) > tolerance || (of(i) >= 0 && !along[of(i) * count + k])) continue;
      pairs.push_back(static_cast<int>(k));
      pairs.push_back(static_cast<int>(i));
    }
  }
  return table(pairs, 2);
}

Bytes bytes(Map& map) {
  check(map.ndim() == 2, "expected a map (rows, columns)");
  return {map.mutable_data(), static_cast<int>(map.shape(0)), static_cast<int>(map.shape(1))};
}

void ground(const Doubles& xyz, const Map& vertex, bool closed, double gap, double step, Map map) {
  check(xyz.ndim() == 3 && xyz.shape(2) == 3, "expected xyz (H, W, 3)");
  check(vertex.ndim() == 2 && vertex.shape(0) == xyz.shape(0) && vertex.shape(1) == xyz.shape(1),
        "expected vertex (H, W)");
  draw_ground(xyz.data(), vertex.data(), static_cast<int>(xyz.shape(0)),
              static_cast<int>(xyz.shape(1)), closed, gap, step, bytes(map));
}

void rays(const Doubles& from, const Doubles& to, Map map) {
  check(from.ndim() == 2 && from.shape(1) == 2 && to.ndim() == 2 && to.shape(1) == 2 &&
            from.shape(0) == to.shape(0),
        "expected from and to (N, 2)");
  draw_rays(from.data(), to.data(), static_cast<int>(from.shape(0)), bytes(map));
}

py::array_t<int> fit(Map blocked, const Integers& cells, const std::vector<double>& angles,
                     const std::vector<double>& half_length,
                     const std::vector<double>& half_width) {
  check(cells.ndim() == 2 && cells.shape(1) == 2, "expected cells (N, 2)");
  check(angles.size() == half_length.size() && angles.size() == half_width.size(),
        "expected half sizes for each angle");
  const std::vector<int> at(cells.data(), cells.data() + cells.size());
  return py::cast(fit_box(bytes(blocked), at, angles, half_length, half_width));
}

// (height, width, 3) [m], remission (height, width) or None, origin (3,).
py::tuple load(const std::string& path) {
  const CloudFile file = read_cloud(path);
  py::array_t<double> xyz({file.height, file.width, 3});
  std::copy(file.xyz.begin(), file.xyz.end(), xyz.mutable_data());
  py::object remission = py::none();
  if (!file.remission.empty()) {
    py::array_t<double> values({file.height, file.width});
    std::copy(file.remission.begin(), file.remission.end(), values.mutable_data());
    remission = values;
  }
  return py::make_tuple(xyz, remission,
                        py::make_tuple(file.origin[0], file.origin[1], file.origin[2]));
}

}  // namespace

PYBIND11_MODULE(_scan_segmentation, m) {
  m.def("read_cloud", &load, py::arg("path"));
  m.def("find_segments", &find, py::arg("uv"), py::arg("tolerance"), py::arg("points"),
        py::arg("length"), py::arg("gap"), py::arg("gap_share"));
  m.def("cluster_segments", &cluster_segments, py::arg("points"), py::arg("where"), py::arg("ends"),
        py::arg("similar_distance"), py::arg("similar_angle"), py::arg("first_fit"),
        py::arg("refit_every"), py::arg("plane_segments"), py::arg("tolerance"),
        py::arg("merge_angle"), py::arg("line_spacing"), py::arg("closed"));
  m.def("supporting", &supporting, py::arg("points"), py::arg("segment"), py::arg("directions"),
        py::arg("planes"), py::arg("tolerance"), py::arg("along_sine"));
  m.def("draw_ground", &ground, py::arg("xyz"), py::arg("vertex"), py::arg("closed"),
        py::arg("gap"), py::arg("step"), py::arg("map"));
  m.def("draw_rays", &rays, py::arg("start"), py::arg("end"), py::arg("map"));
  m.def("fit_box", &fit, py::arg("blocked"), py::arg("cells"), py::arg("angles"),
        py::arg("half_length"), py::arg("half_width"));
}
