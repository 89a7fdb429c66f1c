// RGB-D frames from files and raw arrays.
#pragma once

#include <string>

#include "safe_passage/person_detection/types.h"

namespace safe_passage::person_detection {

// Organised XYZRGB point cloud file (PCD: ascii, binary, compressed). Throws std::runtime_error
// naming the file when it cannot be read, is not organised, or carries no colour.
RgbdFrame load_pcd(const std::string& path);

// Depth image (CV_16UC1 in millimetres, 0 = none; or CV_32FC1 in metres, NaN = none; REP 118) and
// the RGB image registered to it.
RgbdFrame from_depth(const cv::Mat& depth, const cv::Mat& bgr, const Intrinsics& camera);

// Pinhole parameters that made an organised cloud, by least squares over its points. Throws
// std::runtime_error where the cloud has too few points.
Intrinsics estimate_intrinsics(const cv::Mat& xyz);

}  // namespace safe_passage::person_detection
