// Between ROS messages and the person detector's own types.
#pragma once

#include <geometry_msgs/Transform.h>
#include <safe_passage/PersonArray.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/PointCloud2.h>
#include <visualization_msgs/MarkerArray.h>

#include "safe_passage/person_detection/detector.h"

namespace safe_passage::person_detection {

// What is wrong with the cloud for this detector; empty: nothing.
std::string fault_of(const sensor_msgs::PointCloud2& cloud);

// The same of images: the camera that all three tell of must be one, or depth, colours and rays
// do not belong together.
std::string fault_of(const sensor_msgs::Image& depth, const sensor_msgs::Image& rgb,
                     const sensor_msgs::CameraInfo& info);

// Organised XYZRGB cloud; the intrinsics are left out. Check fault_of() first.
RgbdFrame to_frame(const sensor_msgs::PointCloud2& cloud);

// Rectified image: the projection matrix P, as REP 104 has it, or K where P is not filled in.
Intrinsics to_intrinsics(const sensor_msgs::CameraInfo& info);

// The plane z = 0 of a frame whose pose in the camera is T_camera_ground.
GroundPlane to_ground_plane(const geometry_msgs::Transform& T_camera_ground);

// Accepted detections, in the camera's optical frame.
PersonArray to_message(const DetectionResult& result, Method method,
                       const std_msgs::Header& header);

// As the paper's Fig. 4: clusters (blue points), sub-clusters (grey boxes), persons (yellow boxes).
visualization_msgs::MarkerArray to_markers(const DetectionResult& result,
                                           const std_msgs::Header& header);

}  // namespace safe_passage::person_detection
