#include "safe_passage/ros/detector_parameters.h"

#include <cmath>
#include <cstdlib>

#include "safe_passage/ros/parameters.h"

namespace safe_passage::person_detection {
namespace {

std::optional<GroundPlane> read_ground_seed(Parameters& reader) {
  std::vector<double> seed;
  reader.read("ground_seed", seed);
  if (seed.empty()) return std::nullopt;
  if (seed.size() != 4) reader.fail("ground_seed", "must be [nx, ny, nz, height]");
  const Eigen::Vector3d normal(seed[0], seed[1], seed[2]);
  if (!(std::abs(normal.norm() - 1.0) < 0.05) || !(seed[3] > 0.0 && seed[3] < 20.0))
    reader.fail("ground_seed", "must have a unit normal that points up and a height in (0, 20) m");
  return GroundPlane{normal.normalized().cast<float>(), static_cast<float>(seed[3])};
}

void read_stages(Parameters& reader, DetectorParameters& p) {
  reader.read("voxel/leaf", p.voxel.leaf, {0.01, 0.5}, "m");
  reader.read("voxel/max_range", p.voxel.max_range, {0.5, 100.0}, "m");
  reader.read("voxel/sampling", p.voxel.sampling, {0, 8}, "pixels");
  reader.read("ground/seed_band", p.ground.seed_band, {0.01, 2.0}, "m");
  reader.read("ground/track_band", p.ground.track_band, {0.01, 2.0}, "m");
  reader.read("ground/inlier_distance", p.ground.inlier_distance, {0.005, 0.5}, "m");
  reader.read("ground/max_tilt", p.ground.max_tilt, {0.0, 1.5}, "rad");
  reader.read("ground/max_height_change", p.ground.max_height_change, {0.0, 5.0}, "m");
  reader.read("ground/min_inliers", p.ground.min_inliers, {3, 100000}, "voxels");
  reader.read("ground/iterations", p.ground.iterations, {1, 10000}, "");
  reader.read("clusters/tolerance", p.clusters.tolerance, {0.02, 1.0}, "m");
  reader.read("clusters/min_points", p.clusters.min_points, {1, 100000}, "voxels");
  reader.read("clusters/min_above_ground", p.clusters.min_above_ground, {0.0, 1.0}, "m");
  reader.read("clusters/max_above_ground", p.clusters.max_above_ground, {0.5, 10.0}, "m");
  reader.read("heads/min_height", p.heads.min_height, {0.2, 2.5}, "m");
  reader.read("heads/max_height", p.heads.max_height, {0.5, 3.0}, "m");
  reader.read("heads/head_distance", p.heads.head_distance, {0.1, 2.0}, "m");
  reader.read("heads/body_radius", p.heads.body_radius, {0.1, 2.0}, "m");
  reader.read("heads/min_extent", p.heads.min_extent, {0.1, 2.0}, "m");
  reader.read("heads/min_points", p.heads.min_points, {1, 100000}, "voxels");
  reader.read("heads/max_candidates", p.heads.max_candidates, {1, 1000}, "");
}

// A launch file cannot expand the home folder inside an argument's default.
void expand_home(std::string& path) {
  const char* home = std::getenv("HOME");
  if (home && path.compare(0, 2, "~/") == 0) path = home + path.substr(1);
}

void read_confidence(Parameters& reader, DetectorParameters& p) {
  std::string method = "hog";
  reader.read_choice("method", method, {"hog", "yolo"});
  p.method = method == "yolo" ? Method::kYolo : Method::kHog;
  reader.read("hog/threshold", p.hog.threshold, {-10.0, 10.0}, "(SVM margin)");
  reader.read("hog/shifts", p.hog.shifts, {0, 8}, "steps");
  reader.read("hog/sizes", p.hog.sizes);
  if (p.hog.sizes.empty()) reader.fail("hog/sizes", "is empty");
  for (const double size : p.hog.sizes)
    if (!(size >= 0.3 && size <= 3.0)) reader.fail("hog/sizes", "must lie in [0.3, 3]");
  reader.read("yolo/threshold", p.yolo.threshold, {0.0, 1.0}, "(probability)");
  reader.read("yolo/model", p.yolo.model);
  reader.read("yolo/config", p.yolo.config);
  expand_home(p.yolo.model);
  expand_home(p.yolo.config);
  reader.read("yolo/family", p.yolo.family);
  reader.read("yolo/input_width", p.yolo.input_width, {32, 4096}, "px");
  reader.read("yolo/input_height", p.yolo.input_height, {32, 4096}, "px");
  reader.read("yolo/propose", p.yolo.propose);
  reader.read("yolo/person_class", p.yolo.person_class, {0, 10000}, "");
  reader.read("yolo/backend", p.yolo.backend);
  reader.read("yolo/target", p.yolo.target);
}

}  // namespace

const std::set<std::string> kLiveParameters = {"tf_timeout",
                                               "max_age",
                                               "max_future",
                                               "voxel/leaf",
                                               "voxel/max_range",
                                               "voxel/sampling",
                                               "ground/seed_band",
                                               "ground/track_band",
                                               "ground/inlier_distance",
                                               "ground/max_tilt",
                                               "ground/max_height_change",
                                               "ground/min_inliers",
                                               "ground/iterations",
                                               "clusters/tolerance",
                                               "clusters/min_points",
                                               "clusters/min_above_ground",
                                               "clusters/max_above_ground",
                                               "heads/min_height",
                                               "heads/max_height",
                                               "heads/head_distance",
                                               "heads/body_radius",
                                               "heads/min_extent",
                                               "heads/min_points",
                                               "heads/max_candidates",
                                               "hog/threshold",
                                               "yolo/threshold"};

DetectorNodeParameters read_parameters(Parameters& reader) {
  DetectorNodeParameters p;
  reader.read_choice("input", p.input, {"cloud", "depth"});
  reader.read("ground_frame", p.ground_frame);
  p.ground_seed = read_ground_seed(reader);
  reader.read("tf_timeout", p.tf_timeout, {0.0, 1.0}, "s");
  reader.read("max_age", p.max_age, {0.0, 60.0}, "s");
  reader.read("max_future", p.max_future, {0.0, 10.0}, "s");
  reader.read("input_timeout", p.input_timeout, {0.1, 3600.0}, "s");
  read_stages(reader, p.detector);
  read_confidence(reader, p.detector);
  reader.refuse_unknown();
  return p;
}

}  // namespace safe_passage::person_detection
