// The separation monitor's hot kernel for Python.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "safe_passage/separation/shape_distance.h"

namespace py = pybind11;
using namespace safe_passage::separation;
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Integers = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>;

namespace {

void check(bool fits, const char* what) {
  if (!fits) throw std::invalid_argument(what);
}

bool has_columns(const Doubles& array, py::ssize_t columns) {
  return array.ndim() == 2 && array.shape(1) == columns;
}

RobotShape make_shape(const Doubles& corners, double padding, const Doubles& parts) {
  check(has_columns(corners, 2), "expected corners (C, 2)");
  check(has_columns(parts, 5), "expected parts (L, 5)");
  std::vector<Eigen::Vector2d> outline;
  for (py::ssize_t i = 0; i < corners.shape(0); ++i)
    outline.emplace_back(corners.at(i, 0), corners.at(i, 1));
  std::vector<Capsule> capsules;
  for (py::ssize_t i = 0; i < parts.shape(0); ++i)
    capsules.push_back(
        {{parts.at(i, 0), parts.at(i, 1)}, {parts.at(i, 2), parts.at(i, 3)}, parts.at(i, 4)});
  return {std::move(outline), padding, std::move(capsules)};
}

py::array_t<double> distance(const RobotShape& shape, const Doubles& points) {
  check(has_columns(points, 2), "expected points (P, 2)");
  py::array_t<double> found(points.shape(0));
  const auto p = points.unchecked<2>();
  auto d = found.mutable_unchecked<1>();
  for (py::ssize_t i = 0; i < points.shape(0); ++i) d(i) = shape.distance({p(i, 0), p(i, 1)});
  return found;
}

// (Q,) [m] between obstacles whose discs lie around `centres` and the robot at `poses`. Where the
// circle around all of an obstacle's discs is `enough` away, its distance.
py::array_t<double> nearest(const RobotShape& shape, const Doubles& discs, const Integers& start,
                            const Doubles& reach, const Integers& which, const Doubles& centres,
                            const Doubles& poses, const Doubles& enough) {
  const py::ssize_t count = which.size(), obstacles = reach.size();
  check(has_columns(discs, 3), "expected discs (M, 3)");
  check(start.ndim() == 1 && start.size() == obstacles + 1 && start.at(0) == 0 &&
            start.at(obstacles) == discs.shape(0),
        "expected starts (N + 1,) from 0 to M");
  check(has_columns(centres, 2) && centres.shape(0) == count, "expected centres (Q, 2)");
  check(has_columns(poses, 3) && poses.shape(0) == count, "expected poses (Q, 3)");
  check(enough.size() == count, "expected enough (Q,)");
  py::array_t<double> found(count);
  const auto disc = discs.unchecked<2>(), centre = centres.unchecked<2>(),
             pose = poses.unchecked<2>();
  const auto first = start.unchecked<1>(), index = which.unchecked<1>();
  auto d = found.mutable_unchecked<1>();
  for (py::ssize_t q = 0; q < count; ++q) {
    const std::int64_t i = index(q);
    check(i >= 0 && i < obstacles, "expected which (Q,) below N");
    const double c = std::cos(pose(q, 2)), s = std::sin(pose(q, 2));
    const double x = centre(q, 0) - pose(q, 0), y = centre(q, 1) - pose(q, 1);
    const Eigen::Vector2d at(c * x + s * y, c * y - s * x);
    d(q) = shape.distance(at) - reach.at(i);
    if (d(q) >= enough.at(q)) continue;
    d(q) = std::numeric_limits<double>::infinity();
    for (std::int64_t k = first(i); k < first(i + 1); ++k) {
      const Eigen::Vector2d turned(c * disc(k, 0) + s * disc(k, 1),
                                   c * disc(k, 1) - s * disc(k, 0));
      d(q) = std::min(d(q), shape.distance(at + turned) - disc(k, 2));
    }
  }
  return found;
}

}  // namespace

PYBIND11_MODULE(_separation, m) {
  py::class_<RobotShape>(m, "RobotShape")
      .def(py::init(&make_shape), py::arg("corners"), py::arg("padding"), py::arg("parts"))
      .def("distance", &distance, py::arg("points"))
      .def("nearest", &nearest, py::arg("discs"), py::arg("start"), py::arg("reach"),
           py::arg("which"), py::arg("centres"), py::arg("poses"), py::arg("enough"));
}
