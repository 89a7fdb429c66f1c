// The safety areas for Python: tests and benchmarks run the code that the node runs.
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <stdexcept>

#include "safe_passage/safety_area/pipeline.h"

namespace py = pybind11;
using namespace safe_passage::safety_area;
using Floats = py::array_t<float, py::array::c_style | py::array::forcecast>;
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;

namespace {

std::vector<float> to_vector(const Floats& array) {
  if (array.ndim() != 1) throw std::invalid_argument("expected an array of shape (N,)");
  return {array.data(), array.data() + array.size()};
}

Floats to_array(const std::vector<float>& values) {
  return Floats(static_cast<py::ssize_t>(values.size()), values.data());
}

std::vector<Circle> to_circles(const Doubles& rows) {
  if (rows.size() == 0) return {};
  if (rows.ndim() != 2 || rows.shape(1) != 3)
    throw std::invalid_argument("expected circles as an array of shape (N, 3): x, y, radius");
  std::vector<Circle> circles;
  const auto row = rows.unchecked<2>();
  for (py::ssize_t i = 0; i < rows.shape(0); ++i)
    circles.push_back({row(i, 0), row(i, 1), row(i, 2)});
  return circles;
}

Doubles to_rows(const std::vector<Circle>& circles) {
  Doubles rows({static_cast<py::ssize_t>(circles.size()), py::ssize_t{3}});
  auto row = rows.mutable_unchecked<2>();
  for (std::size_t i = 0; i < circles.size(); ++i) {
    const auto at = static_cast<py::ssize_t>(i);
    row(at, 0) = circles[i].x;
    row(at, 1) = circles[i].y;
    row(at, 2) = circles[i].radius;
  }
  return rows;
}

template <typename T>
auto floats(std::vector<float> T::*member) {
  return [member](const T& object) { return to_array(object.*member); };
}

void bind_scans(py::module_& m) {
  py::enum_<InsidePolicy>(m, "InsidePolicy")
      .value("SHRINK", InsidePolicy::kShrink)
      .value("BODY", InsidePolicy::kBody)
      .value("BLOCK", InsidePolicy::kBlock);
  py::enum_<ScanFault>(m, "ScanFault")
      .value("NONE", ScanFault::kNone)
      .value("EMPTY", ScanFault::kEmpty)
      .value("BAD_GEOMETRY", ScanFault::kBadGeometry)
      .value("BEAM_COUNT", ScanFault::kBeamCount);
  py::class_<Scan>(m, "Scan")
      .def(py::init([](const Floats& ranges, double angle_min, double angle_max,
                       double angle_increment, double range_min, double range_max,
                       const Floats& intensities) {
             return Scan{angle_min, angle_max,         angle_increment,       range_min,
                         range_max, to_vector(ranges), to_vector(intensities)};
           }),
           py::arg("ranges"), py::arg("angle_min"), py::arg("angle_max"),
           py::arg("angle_increment"), py::arg("range_min"), py::arg("range_max"),
           py::arg("intensities") = Floats(0))
      .def_property_readonly("ranges", floats(&Scan::ranges))
      .def_property_readonly("intensities", floats(&Scan::intensities))
      .def_readonly("angle_min", &Scan::angle_min)
      .def_readonly("angle_max", &Scan::angle_max)
      .def_readonly("angle_increment", &Scan::angle_increment)
      .def_readonly("range_min", &Scan::range_min)
      .def_readonly("range_max", &Scan::range_max);
  py::class_<MergeParameters>(m, "MergeParameters")
      .def(py::init<>())
      .def_readwrite("inside_policy", &MergeParameters::inside_policy)
      .def_readwrite("clearance", &MergeParameters::clearance)
      .def_readwrite("body_radius", &MergeParameters::body_radius)
      .def_readwrite("intensity", &MergeParameters::intensity);
  py::class_<MergedScan>(m, "MergedScan")
      .def_property_readonly("ranges", floats(&MergedScan::ranges))
      .def_property_readonly("intensities", floats(&MergedScan::intensities))
      .def_property_readonly("safety_ranges", floats(&MergedScan::safety_ranges))
      .def_property_readonly("safety_intensities", floats(&MergedScan::safety_intensities))
      .def_readonly("fault", &MergedScan::fault)
      .def_readonly("inside", &MergedScan::inside)
      .def_readonly("ignored", &MergedScan::ignored);
  m.def(
      "merge",
      [](const Scan& scan, const Doubles& circles, const MergeParameters& params,
         const Outline& robot) { return merge(scan, to_circles(circles), params, robot); },
      "circles: (N, 3) float64, x [m], y [m], radius [m] in the laser's frame; robot: (M, 2) [m]",
      py::arg("scan"), py::arg("circles"), py::arg("params") = MergeParameters{},
      py::arg("robot") = Outline{});
}

void bind_persons(py::module_& m) {
  using Eigen::Vector3d;
  py::class_<Person>(m, "Person")
      .def(py::init([](double stamp, const Vector3d& position, const Vector3d& velocity,
                       std::uint32_t id, const std::string& source, double height) {
             return Person{source, id, stamp, stamp, position, velocity, height};
           }),
           py::arg("stamp"), py::arg("position"), py::arg("velocity") = Vector3d(0, 0, 0),
           py::arg("id") = 0, py::arg("source") = "", py::arg("height") = 0.0)
      .def_readonly("source", &Person::source)
      .def_readonly("id", &Person::id)
      .def_readonly("stamp", &Person::stamp)
      .def_readonly("position", &Person::position)
      .def_readonly("velocity", &Person::velocity)
      .def_readonly("height", &Person::height);
  py::class_<MemoryParameters>(m, "MemoryParameters")
      .def(py::init<>())
      .def_readwrite("hold_time", &MemoryParameters::hold_time)
      .def_readwrite("laser_hold_time", &MemoryParameters::laser_hold_time)
      .def_readwrite("laser_gate", &MemoryParameters::laser_gate)
      .def_readwrite("gate", &MemoryParameters::gate)
      .def_readwrite("max_person_speed", &MemoryParameters::max_person_speed)
      .def_readwrite("max_persons", &MemoryParameters::max_persons);
  py::class_<PersonMemory> memory(m, "PersonMemory");
  py::class_<PersonMemory::Update>(memory, "Update")
      .def_readonly("not_finite", &PersonMemory::Update::not_finite)
      .def_readonly("out_of_order", &PersonMemory::Update::out_of_order)
      .def_readonly("forgotten", &PersonMemory::Update::forgotten);
  memory.def(py::init<const MemoryParameters&>(), py::arg("params") = MemoryParameters{})
      .def("update", &PersonMemory::update)
      .def("follow", &PersonMemory::follow, py::arg("hits"), py::arg("laser"), py::arg("time"))
      .def("at", &PersonMemory::at)
      .def("clear", &PersonMemory::clear)
      .def("__len__", &PersonMemory::size);
}

void bind_pipeline(py::module_& m) {
  py::class_<AreaParameters>(m, "AreaParameters")
      .def(py::init<>())
      .def_readwrite("radius", &AreaParameters::radius)
      .def_readwrite("growth_speed", &AreaParameters::growth_speed)
      .def_readwrite("velocity_stretch", &AreaParameters::velocity_stretch)
      .def_readwrite("max_robot_speed", &AreaParameters::max_robot_speed)
      .def_readwrite("max_robot_turn_rate", &AreaParameters::max_robot_turn_rate)
      .def_readwrite("max_growth", &AreaParameters::max_growth);
  py::class_<LaserPose>(m, "LaserPose")
      .def(py::init([](const Eigen::Matrix4d& T_laser_fixed, double age) {
             return LaserPose{Eigen::Isometry3d(T_laser_fixed), age};
           }),
           py::arg("T_laser_fixed"), py::arg("age") = 0.0);
  py::class_<PipelineParameters>(m, "PipelineParameters")
      .def(py::init<>())
      .def_readwrite("memory", &PipelineParameters::memory)
      .def_readwrite("area", &PipelineParameters::area)
      .def_readwrite("merge", &PipelineParameters::merge);
  m.def(
      "safety_areas",
      [](const std::vector<Person>& persons, double time, const LaserPose& pose,
         const AreaParameters& params) {
        return to_rows(safety_areas(persons, time, pose, params));
      },
      py::arg("persons"), py::arg("time"), py::arg("pose"), py::arg("params") = AreaParameters{});
  py::class_<Pipeline> pipeline(m, "Pipeline");
  py::class_<Pipeline::Result>(pipeline, "Result")
      .def_readonly("scan", &Pipeline::Result::scan)
      .def_readonly("persons", &Pipeline::Result::persons)
      .def_property_readonly("areas", [](const Pipeline::Result& r) { return to_rows(r.areas); });
  pipeline.def(py::init<const PipelineParameters&>(), py::arg("params") = PipelineParameters{})
      .def("remember", &Pipeline::remember)
      .def("merge", &Pipeline::merge, py::arg("scan"), py::arg("time"), py::arg("pose"),
           py::arg("robot") = Outline{})
      .def("clear", &Pipeline::clear);
}

}  // namespace

PYBIND11_MODULE(_safety_area, m) {
  m.doc() = "Human safety areas: person memory, circles, scan merger.";
  bind_scans(m);
  bind_persons(m);
  bind_pipeline(m);
}
