#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "safe_passage/person_detection/confidence.h"

namespace safe_passage::person_detection {
namespace {

[[noreturn]] void wrong_shape(const char* family) {
  throw std::runtime_error(std::string("the model's output is not that of the family ") + family +
                           ": set parameter yolo/family");
}

Box centred(float cx, float cy, float width, float height, float probability) {
  return {{cx - 0.5F * width, cy - 0.5F * height, width, height}, probability};
}

float sigmoid(float logit) { return 1.0F / (1.0F + std::exp(-logit)); }

// Rows [cx cy w h objectness p0 p1 ...].
void append_rows(const cv::Mat& rows, const OutputLayout& layout, float scale_x, float scale_y,
                 bool times_objectness, std::vector<Box>& boxes) {
  for (int i = 0; i < rows.rows; ++i) {
    const auto* row = rows.ptr<float>(i);
    // Darknet has multiplied the class probability with the objectness already.
    const float probability = row[5 + layout.person_class] * (times_objectness ? row[4] : 1.0F);
    if (probability >= layout.threshold)
      boxes.push_back(centred(row[0] * scale_x, row[1] * scale_y, row[2] * scale_x,
                              row[3] * scale_y, probability));
  }
}

// The mean of a distribution given by the logits of its bins 0, 1, 2 ... `stride_bytes` apart.
float expected_bin(const float* logits, int bins, std::size_t step) {
  float largest = logits[0];
  for (int bin = 1; bin < bins; ++bin) largest = std::max(largest, logits[bin * step]);
  float total = 0.0F, mean = 0.0F;
  for (int bin = 0; bin < bins; ++bin) {
    const float weight = std::exp(logits[bin * step] - largest);
    total += weight;
    mean += weight * static_cast<float>(bin);
  }
  return mean / total;
}

// A box by its distances, in cells, from an anchor in the middle of a cell.
Box from_distances(int row, int column, float stride, const std::array<float, 4>& ltrb,
                   float probability) {
  const float x = (static_cast<float>(column) + 0.5F) * stride;
  const float y = (static_cast<float>(row) + 0.5F) * stride;
  return {{x - ltrb[0] * stride, y - ltrb[1] * stride, (ltrb[0] + ltrb[2]) * stride,
           (ltrb[1] + ltrb[3]) * stride},
          probability};
}

}  // namespace

std::vector<Box> decode_darknet(const std::vector<cv::Mat>& outputs, const OutputLayout& layout) {
  std::vector<Box> boxes;
  for (const cv::Mat& output : outputs) {
    if (output.dims != 2 || output.cols <= 5 + layout.person_class) wrong_shape("darknet");
    append_rows(output, layout, static_cast<float>(layout.input.width),
                static_cast<float>(layout.input.height), false, boxes);
  }
  return boxes;
}

std::vector<Box> decode_yolov5(const std::vector<cv::Mat>& outputs, const OutputLayout& layout) {
  const cv::Mat& output = outputs.at(0);
  if (output.dims != 3 || output.size[2] <= 5 + layout.person_class) wrong_shape("yolov5");
  const cv::Mat rows(output.size[1], output.size[2], CV_32F, const_cast<uchar*>(output.data));
  std::vector<Box> boxes;
  append_rows(rows, layout, 1.0F, 1.0F, true, boxes);
  return boxes;
}

std::vector<Box> decode_yolov8(const std::vector<cv::Mat>& outputs, const OutputLayout& layout) {
  const cv::Mat& output = outputs.at(0);
  if (output.dims != 3 || output.size[1] <= 4 + layout.person_class) wrong_shape("yolov8");
  const cv::Mat columns(output.size[1], output.size[2], CV_32F, const_cast<uchar*>(output.data));
  std::vector<Box> boxes;
  for (int i = 0; i < columns.cols; ++i) {
    const float probability = columns.at<float>(4 + layout.person_class, i);
    if (probability >= layout.threshold)
      boxes.push_back(centred(columns.at<float>(0, i), columns.at<float>(1, i),
                              columns.at<float>(2, i), columns.at<float>(3, i), probability));
  }
  return boxes;
}

std::vector<Box> decode_yolov8_heads(const std::vector<cv::Mat>& outputs,
                                     const OutputLayout& layout) {
  constexpr int kBins = 16;
  std::vector<Box> boxes;
  for (const cv::Mat& output : outputs) {
    if (output.dims != 4 || output.size[1] <= 4 * kBins + layout.person_class)
      wrong_shape("yolov8_heads");
    const int rows = output.size[2], columns = output.size[3];
    const auto cells = static_cast<std::size_t>(rows) * columns;
    const float stride = static_cast<float>(layout.input.width) / static_cast<float>(columns);
    const auto* values = output.ptr<float>();
    for (std::size_t cell = 0; cell < cells; ++cell) {
      const float probability = sigmoid(values[(4 * kBins + layout.person_class) * cells + cell]);
      if (probability < layout.threshold) continue;
      std::array<float, 4> ltrb;
      for (int side = 0; side < 4; ++side)
        ltrb[side] = expected_bin(values + side * kBins * cells + cell, kBins, cells);
      boxes.push_back(from_distances(static_cast<int>(cell) / columns,
                                     static_cast<int>(cell) % columns, stride, ltrb, probability));
    }
  }
  return boxes;
}

std::vector<Box> decode_nanodet(const std::vector<cv::Mat>& outputs, const OutputLayout& layout) {
  constexpr int kBins = 8;
  std::vector<Box> boxes;
  for (const float stride : {8.0F, 16.0F, 32.0F}) {
    const int columns = static_cast<int>(std::ceil(layout.input.width / stride));
    const int rows = static_cast<int>(std::ceil(layout.input.height / stride));
    const cv::Mat *classes = nullptr, *distances = nullptr;
    for (const cv::Mat& output : outputs) {
      if (output.dims != 3) wrong_shape("nanodet");
      if (output.size[1] != rows * columns) continue;
      (output.size[2] == 4 * kBins ? distances : classes) = &output;
    }
    if (!classes || !distances || classes->size[2] <= layout.person_class) wrong_shape("nanodet");
    for (int cell = 0; cell < rows * columns; ++cell) {
      const float probability = classes->ptr<float>(0, cell)[layout.person_class];
      if (probability < layout.threshold) continue;
      std::array<float, 4> ltrb;
      for (int side = 0; side < 4; ++side)
        ltrb[side] = expected_bin(distances->ptr<float>(0, cell) + side * kBins, kBins, 1);
      boxes.push_back(from_distances(cell / columns, cell % columns, stride, ltrb, probability));
    }
  }
  return boxes;
}

}  // namespace safe_passage::person_detection
