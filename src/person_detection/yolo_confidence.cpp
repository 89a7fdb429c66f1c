#include <algorithm>
#include <cstdint>
#include <fstream>
#include <map>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "safe_passage/person_detection/confidence.h"

namespace safe_passage::person_detection {
namespace {

constexpr double kSuppressionOverlap = 0.45;  // non-maximum suppression, intersection over union
constexpr double kLeastMatch = 0.40;          // intersection over union of a candidate and its box

using Decoder = std::vector<Box> (*)(const std::vector<cv::Mat>&, const OutputLayout&);
const std::map<std::string, Decoder> kDecoders = {{"darknet", decode_darknet},
                                                  {"yolov5", decode_yolov5},
                                                  {"yolov8", decode_yolov8},
                                                  {"yolov8_heads", decode_yolov8_heads},
                                                  {"nanodet", decode_nanodet}};
const std::map<std::string, cv::dnn::Backend> kBackends = {
    {"default", cv::dnn::DNN_BACKEND_DEFAULT},
    {"opencv", cv::dnn::DNN_BACKEND_OPENCV},
    {"cuda", cv::dnn::DNN_BACKEND_CUDA}};
const std::map<std::string, cv::dnn::Target> kTargets = {
    {"cpu", cv::dnn::DNN_TARGET_CPU},
    {"cuda", cv::dnn::DNN_TARGET_CUDA},
    {"cuda_fp16", cv::dnn::DNN_TARGET_CUDA_FP16},
    {"opencl", cv::dnn::DNN_TARGET_OPENCL}};

template <typename Value>
Value choose(const std::map<std::string, Value>& choices, const std::string& name,
             const std::string& parameter) {
  const auto found = choices.find(name);
  if (found != choices.end()) return found->second;
  std::string known;
  for (const auto& choice : choices) known += " " + choice.first;
  throw std::runtime_error("parameter yolo/" + parameter + " is '" + name +
                           "', known are:" + known);
}

bool ends_with(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

void require_file(const std::string& path, const std::string& parameter) {
  if (path.empty()) throw std::runtime_error("parameter yolo/" + parameter + " is not set");
  if (!std::ifstream(path))
    throw std::runtime_error("parameter yolo/" + parameter + ": no readable file " + path);
}

// OpenCV reads no further than a file goes, and leaves the rest of the weights as memory was: with
// a download that was cut off nobody would be seen, and nobody told. A number too many is as bad:
// then the config is another model's.
void require_all_weights(cv::dnn::Net& net, const std::string& model) {
  std::ifstream file(model, std::ios::binary);
  std::int32_t version[3] = {};  // major, minor, revision
  file.read(reinterpret_cast<char*>(version), sizeof version);
  // the number of images seen has 8 bytes since version 0.2
  const std::size_t seen = std::int64_t{version[0]} * 10 + version[1] >= 2 ? 8 : 4;
  std::size_t told = sizeof version + seen;
  for (const std::string& name : net.getLayerNames()) {
    const auto layer = net.getLayer(net.getLayerId(name));
    if (layer->type == "Region") continue;  // its anchors are the config's
    for (const cv::Mat& blob : layer->blobs) told += blob.total() * sizeof(float);
  }
  file.seekg(0, std::ios::end);
  if (static_cast<std::size_t>(file.tellg()) != told)
    throw std::runtime_error("parameter yolo/model: " + model + " has " +
                             std::to_string(file.tellg()) + " bytes, its config is of " +
                             std::to_string(told));
}

cv::dnn::Net load_darknet(const YoloParameters& parameters) {
  std::string config = parameters.config;
  if (config.empty()) config = parameters.model.substr(0, parameters.model.rfind('.')) + ".cfg";
  require_file(config, "config");
  cv::dnn::Net net = cv::dnn::readNetFromDarknet(config, parameters.model);
  require_all_weights(net, parameters.model);
  return net;
}

cv::dnn::Net load(const YoloParameters& parameters) {
  require_file(parameters.model, "model");
  try {
    return ends_with(parameters.model, ".weights") ? load_darknet(parameters)
                                                   : cv::dnn::readNetFromONNX(parameters.model);
  } catch (const cv::Exception& error) {
    throw std::runtime_error("parameter yolo/model: OpenCV " CV_VERSION " cannot load " +
                             parameters.model + ": " + error.err);
  }
}

// OpenCV itself would fall back to the CPU, with a line in the log that nobody reads.
void require_available(cv::dnn::Backend backend, cv::dnn::Target target,
                       const YoloParameters& parameters) {
  const auto targets = cv::dnn::getAvailableTargets(backend);
  if (std::find(targets.begin(), targets.end(), target) == targets.end())
    throw std::runtime_error("parameters yolo/backend and yolo/target: this OpenCV " CV_VERSION
                             " or machine has no " +
                             parameters.backend + " with " + parameters.target);
}

// By the model's file, then by the shape of its output.
std::string recognise(const YoloParameters& parameters, const std::vector<cv::Mat>& outputs) {
  if (parameters.family != "auto") return parameters.family;
  if (ends_with(parameters.model, ".weights")) return "darknet";
  const cv::Mat& first = outputs.at(0);
  if (outputs.size() >= 6) return "nanodet";
  if (first.dims == 4) return "yolov8_heads";
  if (first.dims == 3) return first.size[1] > first.size[2] ? "yolov5" : "yolov8";
  throw std::runtime_error("parameter yolo/family: the output of " + parameters.model +
                           " is of no known family");
}

cv::Mat to_blob(const cv::Mat& bgr, const YoloParameters& parameters) {
  const cv::Size size(parameters.input_width, parameters.input_height);
  if (parameters.family != "nanodet")
    return cv::dnn::blobFromImage(bgr, 1.0 / 255.0, size, {}, true, false);
  cv::Mat normalised;
  cv::resize(bgr, normalised, size);
  normalised.convertTo(normalised, CV_32FC3);
  cv::subtract(normalised, cv::Scalar(103.53, 116.28, 123.675), normalised);
  cv::divide(normalised, cv::Scalar(57.375, 57.12, 58.395), normalised);
  return cv::dnn::blobFromImage(normalised);
}

std::vector<Box> suppress_overlaps(std::vector<Box> boxes) {
  std::sort(boxes.begin(), boxes.end(),
            [](const Box& a, const Box& b) { return a.probability > b.probability; });
  std::vector<Box> kept;
  for (const Box& box : boxes) {
    const bool repeated = std::any_of(kept.begin(), kept.end(), [&](const Box& other) {
      const float both = (box.rect & other.rect).area();
      return both > kSuppressionOverlap * (box.rect.area() + other.rect.area() - both);
    });
    if (!repeated) kept.push_back(box);
  }
  return kept;
}

}  // namespace

YoloConfidence::YoloConfidence(const YoloParameters& parameters)
    : parameters_(parameters), net_(load(parameters)) {
  if (parameters.input_width % 32 || parameters.input_height % 32 || parameters.input_width < 32 ||
      parameters.input_height < 32)
    throw std::runtime_error(
        "parameters yolo/input_width and input_height must be multiples of 32");
  const auto backend = choose(kBackends, parameters.backend, "backend");
  const auto target = choose(kTargets, parameters.target, "target");
  require_available(backend, target, parameters);
  net_.setPreferableBackend(backend);
  net_.setPreferableTarget(target);
  outputs_ = net_.getUnconnectedOutLayersNames();
  // One run now: a model that does not fit must fail at the start, and the first frame be fast.
  const cv::Mat grey(parameters.input_height, parameters.input_width, CV_8UC3,
                     cv::Scalar::all(128));
  try {
    net_.setInput(to_blob(grey, parameters_));
    std::vector<cv::Mat> outputs;
    net_.forward(outputs, outputs_);
    parameters_.family = recognise(parameters_, outputs);
    detect(grey);
  } catch (const cv::Exception& error) {
    throw std::runtime_error("parameter yolo/model: " + parameters.model + " does not run at " +
                             std::to_string(parameters.input_width) + " x " +
                             std::to_string(parameters.input_height) + ": " + error.err);
  }
}

std::vector<Box> YoloConfidence::detect(const cv::Mat& bgr) {
  net_.setInput(to_blob(bgr, parameters_));
  std::vector<cv::Mat> outputs;
  net_.forward(outputs, outputs_);
  const cv::Size input(parameters_.input_width, parameters_.input_height);
  constexpr double kFloor = 0.05;  // far below any sensible threshold: scores stay comparable
  std::vector<Box> boxes = choose(kDecoders, parameters_.family, "family")(
      outputs, {input, parameters_.person_class, kFloor});
  const float scale_x = static_cast<float>(bgr.cols) / static_cast<float>(input.width);
  const float scale_y = static_cast<float>(bgr.rows) / static_cast<float>(input.height);
  for (Box& box : boxes)
    box.rect = {box.rect.x * scale_x, box.rect.y * scale_y, box.rect.width * scale_x,
                box.rect.height * scale_y};
  return suppress_overlaps(std::move(boxes));
}

Scores YoloConfidence::score(const cv::Mat& bgr, const std::vector<Candidate>& candidates) {
  if (bgr.empty()) return {std::vector<float>(candidates.size(), 0.0F), {}};
  // A box ends at the image's border, so the ROI it is held against must too.
  const cv::Rect2f image(cv::Point2f(), cv::Size2f(bgr.size()));
  std::vector<cv::Rect2f> rois;
  for (const Candidate& candidate : candidates) rois.push_back(cv::Rect2f(candidate.roi) & image);
  return match_boxes(rois, detect(bgr));
}

float overlap(const cv::Rect2f& a, const cv::Rect2f& b) {
  const float both = (a & b).area();
  const float either = a.area() + b.area() - both;
  return either > 0.0F ? both / either : 0.0F;
}

Scores match_boxes(const std::vector<cv::Rect2f>& rois, const std::vector<Box>& boxes) {
  struct Pair {
    float overlap;
    std::size_t roi, box;
  };
  std::vector<Pair> pairs;
  for (std::size_t r = 0; r < rois.size(); ++r)
    for (std::size_t b = 0; b < boxes.size(); ++b) {
      const float shared = overlap(rois[r], boxes[b].rect);
      if (shared >= kLeastMatch) pairs.push_back({shared, r, b});
    }
  std::sort(pairs.begin(), pairs.end(),
            [](const Pair& a, const Pair& b) { return a.overlap > b.overlap; });
  Scores result{std::vector<float>(rois.size(), 0.0F), {}};
  std::vector<bool> matched(rois.size()), used(boxes.size());
  for (const Pair& pair : pairs) {
    if (matched[pair.roi] || used[pair.box]) continue;
    matched[pair.roi] = used[pair.box] = true;
    result.scores[pair.roi] = boxes[pair.box].probability;
  }
  for (std::size_t b = 0; b < boxes.size(); ++b)
    if (!used[b]) result.unmatched.push_back(boxes[b]);
  return result;
}

}  // namespace safe_passage::person_detection
