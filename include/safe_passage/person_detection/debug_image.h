// The image with every candidate's ROI and score, for people to look at.
#pragma once

#include <opencv2/core.hpp>

#include "safe_passage/person_detection/detector.h"

namespace safe_passage::person_detection {

// A copy of `bgr` (CV_8UC3): accepted candidates green, the others grey.
cv::Mat draw_debug(const cv::Mat& bgr, const DetectionResult& result);

}  // namespace safe_passage::person_detection
