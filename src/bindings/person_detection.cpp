// Python module safe_passage._person_detection: the detector that the node runs, without ROS.
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "safe_passage/person_detection/debug_image.h"
#include "safe_passage/person_detection/detector.h"
#include "safe_passage/person_detection/frame_io.h"

namespace py = pybind11;
using namespace safe_passage::person_detection;  // NOLINT: a binding names everything in it

namespace {

template <typename T>
using Array = py::array_t<T, py::array::c_style | py::array::forcecast>;

template <typename T>
cv::Mat to_mat(const Array<T>& array, int type) {
  const int channels = CV_MAT_CN(type);
  const bool fits =
      channels == 1 ? array.ndim() == 2 : array.ndim() == 3 && array.shape(2) == channels;
  if (!fits) throw std::invalid_argument("image array has the wrong shape");
  return cv::Mat(static_cast<int>(array.shape(0)), static_cast<int>(array.shape(1)), type,
                 const_cast<T*>(array.data()))
      .clone();
}

template <typename T>
py::array_t<T> to_array(const cv::Mat& mat) {
  return py::array_t<T>({mat.rows, mat.cols, mat.channels()}, mat.ptr<T>());
}

py::array_t<float> to_array(const Points& points) {
  return py::array_t<float>({static_cast<int>(points.size()), 3},
                            points.empty() ? nullptr : points.front().data());
}

}  // namespace

PYBIND11_MODULE(_person_detection, m) {
  m.doc() = "RGB-D person detector (paper 002, section 2.2); metres, camera optical frame.";

  py::class_<Intrinsics>(m, "Intrinsics")
      .def(py::init([](double fx, double fy, double cx, double cy) {
             return Intrinsics{fx, fy, cx, cy};
           }),
           py::arg("fx"), py::arg("fy"), py::arg("cx"), py::arg("cy"))
      .def_readwrite("fx", &Intrinsics::fx)
      .def_readwrite("fy", &Intrinsics::fy)
      .def_readwrite("cx", &Intrinsics::cx)
      .def_readwrite("cy", &Intrinsics::cy);

  py::class_<RgbdFrame>(m, "RgbdFrame", "Organised cloud and image.")
      .def(py::init([](const Array<float>& xyz, const Array<std::uint8_t>& bgr,
                       const Intrinsics& camera) {
             return RgbdFrame{to_mat(xyz, CV_32FC3), to_mat(bgr, CV_8UC3), camera};
           }),
           py::arg("xyz"), py::arg("bgr"), py::arg("camera"))
      .def_property_readonly("xyz", [](const RgbdFrame& f) { return to_array<float>(f.xyz); })
      .def_property_readonly("bgr",
                             [](const RgbdFrame& f) { return to_array<std::uint8_t>(f.bgr); })
      .def_readonly("camera", &RgbdFrame::camera);

  py::class_<GroundPlane>(m, "GroundPlane", "Height over the ground = normal . p + offset.")
      .def(py::init([](const Eigen::Vector3f& normal, float offset) {
             return GroundPlane{normal.normalized(), offset / normal.norm()};
           }),
           py::arg("normal"), py::arg("offset"))
      .def_readonly("normal", &GroundPlane::normal)
      .def_readonly("offset", &GroundPlane::offset);

  py::enum_<GroundState>(m, "GroundState")
      .value("TRACKED", GroundState::kTracked)
      .value("HELD", GroundState::kHeld)
      .value("UNKNOWN", GroundState::kUnknown);
  py::class_<GroundEstimate>(m, "GroundEstimate")
      .def_readonly("plane", &GroundEstimate::plane)
      .def_readonly("state", &GroundEstimate::state)
      .def_readonly("inliers", &GroundEstimate::inliers);

  py::class_<Candidate>(m, "Candidate")
      .def_readonly("points", &Candidate::points)
      .def_readonly("head", &Candidate::head)
      .def_readonly("low", &Candidate::low)
      .def_readonly("high", &Candidate::high)
      .def_readonly("headness", &Candidate::headness)
      .def_property_readonly("roi", [](const Candidate& c) {
        return py::make_tuple(c.roi.x, c.roi.y, c.roi.width, c.roi.height);
      });
  py::class_<Detection>(m, "Detection")
      .def_readonly("candidate", &Detection::candidate)
      .def_readonly("confidence", &Detection::confidence)
      .def_readonly("accepted", &Detection::accepted);

  py::class_<DetectionResult>(m, "DetectionResult")
      .def_readonly("voxels", &DetectionResult::voxels)
      .def_readonly("ground", &DetectionResult::ground)
      .def_property_readonly("points", [](const DetectionResult& r) { return to_array(r.points); })
      .def(
          "camera_points",
          [](const DetectionResult& r, const Candidate& candidate) {
            const GroundFrame frame(r.ground.plane);
            Points points;
            for (const int i : candidate.points) points.push_back(frame.to_camera(r.points.at(i)));
            return to_array(points);
          },
          py::arg("candidate"), "The candidate's points (N, 3) in the camera's frame.")
      .def_readonly("clusters", &DetectionResult::clusters)
      .def_readonly("detections", &DetectionResult::detections)
      .def_property_readonly("times_ms", [](const DetectionResult& r) {
        py::dict times;
        for (const auto& time : r.times) times[py::str(time.stage)] = time.ms;
        return times;
      });

  py::class_<VoxelParameters>(m, "VoxelParameters")
      .def(py::init<>())
      .def_readwrite("leaf", &VoxelParameters::leaf)
      .def_readwrite("max_range", &VoxelParameters::max_range)
      .def_readwrite("sampling", &VoxelParameters::sampling);
  py::class_<GroundParameters>(m, "GroundParameters")
      .def(py::init<>())
      .def_readwrite("seed_band", &GroundParameters::seed_band)
      .def_readwrite("track_band", &GroundParameters::track_band)
      .def_readwrite("inlier_distance", &GroundParameters::inlier_distance)
      .def_readwrite("max_tilt", &GroundParameters::max_tilt)
      .def_readwrite("max_height_change", &GroundParameters::max_height_change)
      .def_readwrite("min_inliers", &GroundParameters::min_inliers)
      .def_readwrite("iterations", &GroundParameters::iterations);
  py::class_<ClusterParameters>(m, "ClusterParameters")
      .def(py::init<>())
      .def_readwrite("tolerance", &ClusterParameters::tolerance)
      .def_readwrite("min_points", &ClusterParameters::min_points)
      .def_readwrite("min_above_ground", &ClusterParameters::min_above_ground)
      .def_readwrite("max_above_ground", &ClusterParameters::max_above_ground);
  py::class_<HeadParameters>(m, "HeadParameters")
      .def(py::init<>())
      .def_readwrite("min_height", &HeadParameters::min_height)
      .def_readwrite("max_height", &HeadParameters::max_height)
      .def_readwrite("head_distance", &HeadParameters::head_distance)
      .def_readwrite("body_radius", &HeadParameters::body_radius)
      .def_readwrite("min_extent", &HeadParameters::min_extent)
      .def_readwrite("min_points", &HeadParameters::min_points)
      .def_readwrite("max_candidates", &HeadParameters::max_candidates);
  py::class_<HogParameters>(m, "HogParameters")
      .def(py::init<>())
      .def_readwrite("threshold", &HogParameters::threshold)
      .def_readwrite("shifts", &HogParameters::shifts)
      .def_readwrite("sizes", &HogParameters::sizes);
  py::class_<YoloParameters>(m, "YoloParameters")
      .def(py::init<>())
      .def_readwrite("threshold", &YoloParameters::threshold)
      .def_readwrite("model", &YoloParameters::model)
      .def_readwrite("config", &YoloParameters::config)
      .def_readwrite("family", &YoloParameters::family)
      .def_readwrite("input_width", &YoloParameters::input_width)
      .def_readwrite("input_height", &YoloParameters::input_height)
      .def_readwrite("propose", &YoloParameters::propose)
      .def_readwrite("person_class", &YoloParameters::person_class)
      .def_readwrite("backend", &YoloParameters::backend)
      .def_readwrite("target", &YoloParameters::target);
  py::enum_<Method>(m, "Method").value("HOG", Method::kHog).value("YOLO", Method::kYolo);
  py::class_<DetectorParameters>(m, "DetectorParameters")
      .def(py::init<>())
      .def_readwrite("method", &DetectorParameters::method)
      .def_readwrite("voxel", &DetectorParameters::voxel)
      .def_readwrite("ground", &DetectorParameters::ground)
      .def_readwrite("clusters", &DetectorParameters::clusters)
      .def_readwrite("heads", &DetectorParameters::heads)
      .def_readwrite("hog", &DetectorParameters::hog)
      .def_readwrite("yolo", &DetectorParameters::yolo);

  py::class_<PersonDetector>(m, "PersonDetector")
      .def(py::init<const DetectorParameters&>(), py::arg("parameters"))
      .def("detect", &PersonDetector::detect, py::arg("frame"), py::arg("ground_seed") = py::none())
      .def("reset", &PersonDetector::reset);

  py::class_<YoloConfidence>(m, "YoloConfidence")
      .def(py::init<const YoloParameters&>(), py::arg("parameters"))
      .def(
          "detect",
          [](YoloConfidence& self, const Array<std::uint8_t>& bgr) {
            py::list rows;
            for (const Box& b : self.detect(to_mat(bgr, CV_8UC3)))
              rows.append(
                  py::make_tuple(b.rect.x, b.rect.y, b.rect.width, b.rect.height, b.probability));
            return rows;
          },
          py::arg("bgr"), "(x, y, width, height, probability) [px] of every person seen.");

  m.def("load_pcd", &load_pcd, py::arg("path"));
  m.def(
      "from_depth",
      [](const Array<float>& depth, const Array<std::uint8_t>& bgr, const Intrinsics& camera) {
        return from_depth(to_mat(depth, CV_32FC1), to_mat(bgr, CV_8UC3), camera);
      },
      py::arg("depth"), py::arg("bgr"), py::arg("camera"), "Depth in metres, NaN or 0 = none.");
  m.def(
      "draw_debug",
      [](const Array<std::uint8_t>& bgr, const DetectionResult& result) {
        return to_array<std::uint8_t>(draw_debug(to_mat(bgr, CV_8UC3), result));
      },
      py::arg("bgr"), py::arg("result"));
  m.def(
      "find_ground",
      [](const RgbdFrame& frame, const Eigen::Vector3f& up, double max_tilt) {
        return find_ground(VoxelGrid(VoxelParameters{}).filter(frame.xyz, frame.depth_focal()), up,
                           max_tilt);
      },
      py::arg("frame"), py::arg("up") = Eigen::Vector3f(0.0F, -1.0F, 0.0F),
      py::arg("max_tilt") = 0.5, "The lowest large plane under the camera, or None.");
}
