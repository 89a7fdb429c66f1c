#include <algorithm>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "safe_passage/person_detection/confidence.h"

namespace safe_passage::person_detection {
namespace {

constexpr int kWindowWidth = 64, kWindowHeight = 128;  // [px] of the trained window
constexpr int kPersonHeight = 96;                      // [px] of the person in it
constexpr int kStep = 8;                               // [px] HOG's cell: a shift that reuses cells
constexpr float kHopeless = -2.0F, kClear = 0.7F;  // margins that another size will not overturn

}  // namespace

HogConfidence::HogConfidence(const HogParameters& parameters) : parameters_(parameters) {
  hog_.setSVMDetector(cv::HOGDescriptor::getDefaultPeopleDetector());
}

Scores HogConfidence::score(const cv::Mat& bgr, const std::vector<Candidate>& candidates) {
  std::vector<float> scores(candidates.size());
  cv::parallel_for_(cv::Range(0, static_cast<int>(candidates.size())), [&](const cv::Range& range) {
    for (int i = range.start; i < range.end; ++i) {
      scores[i] = -std::numeric_limits<float>::infinity();
      for (const double size : parameters_.sizes) {
        scores[i] = std::max(scores[i], margin(bgr, candidates[i].roi, size));
        if (scores[i] < kHopeless || scores[i] > kClear) break;
      }
    }
  });
  return {std::move(scores), {}};
}

float HogConfidence::margin(const cv::Mat& bgr, const cv::Rect& roi, double size) const {
  constexpr float kNone = -std::numeric_limits<float>::infinity();
  if (roi.height < kPersonHeight / 8 || bgr.empty()) return kNone;
  // Cut out the window and its shifts; what lies outside the image repeats its border.
  const double scale = kPersonHeight / (size * roi.height);  // window px an image px
  const int width = kWindowWidth + 2 * kStep * parameters_.shifts;
  const int height = kWindowHeight + 2 * kStep * parameters_.shifts;
  const cv::Point2d origin(roi.x + 0.5 * roi.width - 0.5 * width / scale,
                           roi.y + 0.5 * roi.height - 0.5 * height / scale);
  const cv::Rect wanted(cv::Point(origin), cv::Size2d(width / scale, height / scale));
  const cv::Rect inside = wanted & cv::Rect({0, 0}, bgr.size());
  const cv::Rect placed(cv::Point((inside.tl() - wanted.tl()) * scale),
                        cv::Size2d(inside.width * scale, inside.height * scale));
  const cv::Rect in_patch = placed & cv::Rect(0, 0, width, height);
  if (in_patch.empty()) return kNone;
  cv::Mat visible, patch;
  cv::resize(bgr(inside), visible, in_patch.size(), 0, 0,
             scale < 1.0 ? cv::INTER_AREA : cv::INTER_LINEAR);
  cv::copyMakeBorder(visible, patch, in_patch.y, height - in_patch.br().y, in_patch.x,
                     width - in_patch.br().x, cv::BORDER_REPLICATE);
  std::vector<cv::Point> found;
  std::vector<double> margins;
  hog_.detect(patch, found, margins, -1e9, cv::Size(kStep, kStep));
  return margins.empty() ? kNone
                         : static_cast<float>(*std::max_element(margins.begin(), margins.end()));
}

}  // namespace safe_passage::person_detection
