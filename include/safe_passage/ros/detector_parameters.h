// The person_detector node's private parameters.
#pragma once

#include <ros/ros.h>

#include <optional>
#include <set>
#include <string>

#include "safe_passage/person_detection/detector.h"
#include "safe_passage/ros/parameters.h"

namespace safe_passage::person_detection {

struct DetectorNodeParameters {
  DetectorParameters detector;
  std::string input = "cloud";                  // cloud, or depth (depth + RGB + camera info)
  std::string ground_frame = "base_footprint";  // its plane z = 0 is the ground
  std::optional<GroundPlane> ground_seed;  // instead of tf: [nx, ny, nz, height of the camera in m]
  double tf_timeout = 0.05;                // [s] to wait for the transform at the frame's stamp
  double max_age = 1.0;                    // [s] older frames are dropped
  double max_future = 0.1;                 // [s] frames stamped farther ahead are dropped
  double input_timeout = 2.0;              // [s] silence reported as an error
};

// May be changed while the node runs; not the input, the method and its model.
extern const std::set<std::string> kLiveParameters;

// Throws std::runtime_error naming the parameter at fault.
DetectorNodeParameters read_parameters(Parameters& reader);

}  // namespace safe_passage::person_detection
