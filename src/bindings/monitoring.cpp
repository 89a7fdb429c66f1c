// The tracker's hot kernels for Python.
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <stdexcept>

#include "safe_passage/monitoring/shape_alignment.h"

namespace py = pybind11;
using namespace safe_passage::monitoring;
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Starts = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>;

namespace {

void check(const Doubles& points, const Starts& start) {
  if (points.ndim() != 2 || points.shape(1) != 2)
    throw std::invalid_argument("expected points as an array of shape (T, 2)");
  if (start.ndim() != 1 || start.size() < 1 || start.at(0) != 0 ||
      start.at(start.size() - 1) != points.shape(0))
    throw std::invalid_argument("expected starts (N + 1,) from 0 to T");
}

Points list(const Doubles& points, const Starts& start, py::ssize_t i) {
  const auto row = points.unchecked<2>();
  Points chosen;
  for (std::int64_t at = start.at(i); at < start.at(i + 1); ++at)
    chosen.emplace_back(row(at, 0), row(at, 1));
  return chosen;
}

py::tuple align_all(ShapeAligner& aligner, const Doubles& hypotheses, const Starts& first,
                    const Doubles& objects, const Starts& second, bool exhaustively) {
  check(hypotheses, first);
  check(objects, second);
  if (first.size() != second.size())
    throw std::invalid_argument("expected as many objects as hypotheses");
  const py::ssize_t count = first.size() - 1;
  Doubles displacement({count, py::ssize_t{2}}), overlap(count);
  Doubles information({count, py::ssize_t{2}, py::ssize_t{2}});
  auto d = displacement.mutable_unchecked<2>();
  auto o = overlap.mutable_unchecked<1>();
  auto a = information.mutable_unchecked<3>();
  for (py::ssize_t i = 0; i < count; ++i) {
    const Points hypothesis = list(hypotheses, first, i), object = list(objects, second, i);
    const Alignment found = exhaustively ? aligner.align_exhaustively(hypothesis, object)
                                         : aligner.align(hypothesis, object);
    o(i) = found.overlap;
    for (int r = 0; r < 2; ++r) {
      d(i, r) = found.displacement[r];
      for (int c = 0; c < 2; ++c) a(i, r, c) = found.information(r, c);
    }
  }
  return py::make_tuple(displacement, overlap, information);
}

}  // namespace

PYBIND11_MODULE(_monitoring, m) {
  py::class_<ShapeAligner>(m, "ShapeAligner")
      .def(py::init<double, double>(), py::arg("cell"), py::arg("reach"))
      .def("align_all", &align_all, py::arg("hypotheses"), py::arg("hypothesis_start"),
           py::arg("objects"), py::arg("object_start"), py::arg("exhaustively") = false);
}
