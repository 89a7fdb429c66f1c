#include "safe_passage/person_detection/frame_io.h"

#include <pcl/io/pcd_io.h>
#include <pcl/point_types.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "safe_passage/core/pcd_file.h"

namespace safe_passage::person_detection {

namespace {

// PCL 1.13 crashes on a file without the fields it wants.
bool has_fields(const pcl::PCLPointCloud2& cloud) {
  const auto has = [&cloud](const char* name) {
    return std::any_of(cloud.fields.begin(), cloud.fields.end(),
                       [name](const auto& field) { return field.name == name; });
  };
  return has("x") && has("y") && has("z") && (has("rgb") || has("rgba"));
}

}  // namespace

RgbdFrame load_pcd(const std::string& path) {
  refuse_unsound_pcd(path);
  pcl::PCDReader reader;
  pcl::PCLPointCloud2 header;
  pcl::PointCloud<pcl::PointXYZRGB> cloud;
  if (reader.readHeader(path, header) != 0 || !has_fields(header) ||
      reader.read(path, cloud) != 0 || cloud.empty())
    throw std::runtime_error(path + ": no readable XYZRGB point cloud");
  if (!cloud.isOrganized()) throw std::runtime_error(path + ": the cloud is not organised");
  RgbdFrame frame;
  frame.xyz.create(static_cast<int>(cloud.height), static_cast<int>(cloud.width), CV_32FC3);
  frame.bgr.create(frame.xyz.size(), CV_8UC3);
  for (int row = 0; row < frame.xyz.rows; ++row)
    for (int column = 0; column < frame.xyz.cols; ++column) {
      const auto& point = cloud.at(column, row);
      frame.xyz.at<cv::Vec3f>(row, column) = {point.x, point.y, point.z};
      frame.bgr.at<cv::Vec3b>(row, column) = {point.b, point.g, point.r};
    }
  try {
    frame.camera = estimate_intrinsics(frame.xyz);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(path + ": " + error.what());
  }
  return frame;
}

RgbdFrame from_depth(const cv::Mat& depth, const cv::Mat& bgr, const Intrinsics& camera) {
  if (depth.type() != CV_16UC1 && depth.type() != CV_32FC1)
    throw std::runtime_error("depth image must be 16UC1 [mm] or 32FC1 [m]");
  if (!(camera.fx > 0.0 && camera.fy > 0.0 && std::isfinite(camera.fx + camera.fy)))
    throw std::runtime_error("camera info: focal length is not positive");
  if (!std::isfinite(camera.cx + camera.cy))
    throw std::runtime_error("camera info: principal point is not finite");
  RgbdFrame frame{cv::Mat(depth.size(), CV_32FC3), bgr, camera};
  // The intrinsics are the RGB image's: scale them where the depth image is smaller.
  const double scale = bgr.empty() ? 1.0 : static_cast<double>(depth.cols) / bgr.cols;
  const auto fx = static_cast<float>(camera.fx * scale), fy = static_cast<float>(camera.fy * scale);
  const auto cx = static_cast<float>(camera.cx * scale), cy = static_cast<float>(camera.cy * scale);
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  for (int row = 0; row < depth.rows; ++row) {
    auto* out = frame.xyz.ptr<cv::Vec3f>(row);
    const float y = (static_cast<float>(row) - cy) / fy;
    for (int column = 0; column < depth.cols; ++column) {
      const float raw = depth.type() == CV_16UC1 ? 1e-3F * depth.at<std::uint16_t>(row, column)
                                                 : depth.at<float>(row, column);
      const float z = raw > 0.0F && std::isfinite(raw) ? raw : kNan;
      out[column] = {(static_cast<float>(column) - cx) / fx * z, y * z, z};
    }
  }
  return frame;
}

Intrinsics estimate_intrinsics(const cv::Mat& xyz) {
  // u = fx X/Z + cx and v = fy Y/Z + cy: two straight lines.
  Eigen::Matrix2d normal_u = Eigen::Matrix2d::Zero(), normal_v = normal_u;
  Eigen::Vector2d right_u = Eigen::Vector2d::Zero(), right_v = right_u;
  int count = 0;
  for (int row = 0; row < xyz.rows; row += 2)
    for (int column = 0; column < xyz.cols; column += 2) {
      const auto& p = xyz.at<cv::Vec3f>(row, column);
      if (!(std::isfinite(p[0]) && std::isfinite(p[1]) && p[2] > 0.0F && std::isfinite(p[2])))
        continue;
      const Eigen::Vector2d a(p[0] / p[2], 1.0), b(p[1] / p[2], 1.0);
      normal_u += a * a.transpose();
      normal_v += b * b.transpose();
      right_u += a * column;
      right_v += b * row;
      ++count;
    }
  if (count < 100) throw std::runtime_error("cloud has too few points to tell its camera from");
  const Eigen::Vector2d u = normal_u.ldlt().solve(right_u), v = normal_v.ldlt().solve(right_v);
  return {u[0], v[0], u[1], v[1]};
}

}  // namespace safe_passage::person_detection
