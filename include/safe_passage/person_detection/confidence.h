// How sure are we that a candidate is a person: two scorers for the same candidates (paper 002,
// section 2.2), HOG + SVM (Dalal and Triggs) and YOLO.
#pragma once

#include <memory>
#include <opencv2/dnn.hpp>
#include <opencv2/objdetect.hpp>

#include "safe_passage/person_detection/types.h"

namespace safe_passage::person_detection {

struct Box {
  cv::Rect2f rect;  // [px]
  float probability;
};

struct Scores {
  std::vector<float> scores;   // one a candidate; greater means surer, the scale is the method's
  std::vector<Box> unmatched;  // persons in the picture that are no candidate's
};

class PersonConfidence {
 public:
  virtual ~PersonConfidence() = default;

  // The candidates' ROIs are filled in.
  virtual Scores score(const cv::Mat& bgr, const std::vector<Candidate>& candidates) = 0;
};

struct HogParameters {
  double threshold = -0.3;  // SVM margin; under the boundary: rather a person too many
  // The ROI comes from depth, the window from pictures: the best margin of a few windows counts.
  int shifts = 1;                               // steps of 8 px of the window each way
  std::vector<double> sizes = {1.0, 0.9, 1.1};  // of the person, in shares of the ROI's height
};

// OpenCV's people SVM on the candidate's crop.
class HogConfidence : public PersonConfidence {
 public:
  explicit HogConfidence(const HogParameters& parameters);
  Scores score(const cv::Mat& bgr, const std::vector<Candidate>& candidates) override;

 private:
  float margin(const cv::Mat& bgr, const cv::Rect& roi, double size) const;

  HogParameters parameters_;
  cv::HOGDescriptor hog_;
};

struct YoloParameters {
  double threshold = 0.2;  // probability from which a candidate is a person
  std::string model;       // path of .weights (Darknet) or .onnx
  std::string config;      // path of the .cfg (Darknet only); empty: the model's with .cfg
  std::string family =
      "auto";  // auto, darknet, yolov5 (to v7), yolov8 (and later), yolov8_heads, nanodet
  int input_width = 416;  // [px] multiples of 32
  int input_height = 320;
  bool propose = true;   // persons that only the picture shows are located in it by depth
  int person_class = 0;  // 0 in COCO
  std::string backend = "default";  // default, opencv, cuda
  std::string target = "cpu";       // cpu, cuda, cuda_fp16, opencl
};

class YoloConfidence : public PersonConfidence {
 public:
  // Throws std::runtime_error naming the parameter when the model cannot be used.
  explicit YoloConfidence(const YoloParameters& parameters);
  Scores score(const cv::Mat& bgr, const std::vector<Candidate>& candidates) override;

  // Persons in the whole image, before they are held against candidates.
  std::vector<Box> detect(const cv::Mat& bgr);

 private:
  YoloParameters parameters_;
  cv::dnn::Net net_;
  std::vector<std::string> outputs_;
};

// Intersection over union.
float overlap(const cv::Rect2f& a, const cv::Rect2f& b);

// One score a ROI: the probability of the box it overlaps most, 0 without one. A box serves one
// ROI; those that serve none are unmatched.
Scores match_boxes(const std::vector<cv::Rect2f>& rois, const std::vector<Box>& boxes);

// Decoders of a network's raw output to boxes in network pixels, one a family. They throw
// std::runtime_error when the output has not the family's shape.
struct OutputLayout {
  cv::Size input;  // [px] of the network
  int person_class;
  double threshold;  // boxes below it are left out
};
// Rows [cx cy w h objectness p0 p1 ...], in shares of the input.
std::vector<Box> decode_darknet(const std::vector<cv::Mat>& outputs, const OutputLayout& layout);
// 1 x N x (5 + classes): the same rows in pixels.
std::vector<Box> decode_yolov5(const std::vector<cv::Mat>& outputs, const OutputLayout& layout);
// 1 x (4 + classes) x N: columns [cx cy w h p0 p1 ...] in pixels.
std::vector<Box> decode_yolov8(const std::vector<cv::Mat>& outputs, const OutputLayout& layout);
// Cut at the heads, as OpenCV 4.6 needs it. A stride: 1 x (64 + classes) x rows x columns, 4 x 16
// bins of the distance to left, top, right, bottom, then class logits.
std::vector<Box> decode_yolov8_heads(const std::vector<cv::Mat>& outputs,
                                     const OutputLayout& layout);
// A stride: class probabilities 1 x N x classes and 1 x N x 32, 4 x 8 bins of distances.
std::vector<Box> decode_nanodet(const std::vector<cv::Mat>& outputs, const OutputLayout& layout);

}  // namespace safe_passage::person_detection
