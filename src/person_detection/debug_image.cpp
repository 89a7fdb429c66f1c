#include "safe_passage/person_detection/debug_image.h"

#include <cstdio>
#include <opencv2/imgproc.hpp>

namespace safe_passage::person_detection {

cv::Mat draw_debug(const cv::Mat& bgr, const DetectionResult& result) {
  cv::Mat image = bgr.clone();
  for (const Detection& detection : result.detections) {
    const cv::Scalar colour =
        detection.accepted ? cv::Scalar(0, 220, 0) : cv::Scalar(160, 160, 160);
    const cv::Rect& roi = detection.candidate.roi;
    cv::rectangle(image, roi, colour, detection.accepted ? 2 : 1);
    char label[48];
    const int end =
        std::snprintf(label, sizeof label, "%.1f", static_cast<double>(detection.confidence));
    if (detection.accepted)
      std::snprintf(label + end, sizeof label - end, "  %.2f m",
                    static_cast<double>(detection.candidate.head.z()));
    const cv::Point at(std::max(2, roi.x + 3), std::max(14, roi.y + 14));
    cv::putText(image, label, at, cv::FONT_HERSHEY_SIMPLEX, 0.45, cv::Scalar::all(0), 3);
    cv::putText(image, label, at, cv::FONT_HERSHEY_SIMPLEX, 0.45, colour, 1);
  }
  return image;
}

}  // namespace safe_passage::person_detection
