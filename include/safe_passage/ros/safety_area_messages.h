// Between ROS messages and the safety areas' plain types.
#pragma once

#include <geometry_msgs/Transform.h>
#include <safe_passage/PersonArray.h>
#include <sensor_msgs/LaserScan.h>
#include <visualization_msgs/MarkerArray.h>

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "safe_passage/ros/diagnostics.h"
#include "safe_passage/safety_area/pipeline.h"

namespace safe_passage {

inline safety_area::Scan to_scan(const sensor_msgs::LaserScan& message) {
  safety_area::Scan scan;
  scan.angle_min = message.angle_min;
  scan.angle_max = message.angle_max;
  scan.angle_increment = message.angle_increment;
  scan.range_min = message.range_min;
  scan.range_max = message.range_max;
  scan.ranges = message.ranges;
  scan.intensities = message.intensities;
  return scan;
}

inline Outcome to_outcome(safety_area::ScanFault fault) {
  if (fault == safety_area::ScanFault::kNone) return Outcome::kOk;
  return fault == safety_area::ScanFault::kEmpty ? Outcome::kEmpty : Outcome::kBadFields;
}

// tf2 refuses the leading slash that old drivers still write.
inline std::string tf_name(const std::string& frame_id) {
  return frame_id.compare(0, 1, "/") == 0 ? frame_id.substr(1) : frame_id;
}

inline Eigen::Isometry3d to_isometry(const geometry_msgs::Transform& transform) {
  const auto& t = transform.translation;
  const auto& q = transform.rotation;
  return Eigen::Translation3d(t.x, t.y, t.z) * Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized();
}

inline std::vector<safety_area::Person> to_persons(const PersonArray& message,
                                                   const Eigen::Isometry3d& T_fixed_camera) {
  std::vector<safety_area::Person> persons;
  for (const Person& seen : message.persons) {
    safety_area::Person person;
    person.source = message.header.frame_id;
    person.id = seen.id;
    person.stamp = message.header.stamp.toSec();
    person.position =
        T_fixed_camera * Eigen::Vector3d(seen.position.x, seen.position.y, seen.position.z);
    person.velocity = T_fixed_camera.linear() *
                      Eigen::Vector3d(seen.velocity.x, seen.velocity.y, seen.velocity.z);
    person.height = seen.height;
    persons.push_back(person);
  }
  return persons;
}

inline visualization_msgs::Marker cylinder(const std_msgs::Header& header, const std::string& ns,
                                           int id, const Eigen::Vector3d& centre, double radius,
                                           double height) {
  visualization_msgs::Marker marker;
  marker.header = header;
  marker.ns = ns;
  marker.id = id;
  marker.type = visualization_msgs::Marker::CYLINDER;
  marker.pose.position.x = centre.x();
  marker.pose.position.y = centre.y();
  marker.pose.position.z = centre.z();
  marker.pose.orientation.w = 1.0;
  marker.scale.x = marker.scale.y = 2.0 * radius;
  marker.scale.z = height;
  marker.lifetime = ros::Duration(0.5);  // nothing stays when the node dies
  return marker;
}

// Green discs for the areas in the laser's plane, yellow cylinders for the persons.
inline visualization_msgs::MarkerArray to_markers(const std_msgs::Header& laser_header,
                                                  const std::string& fixed_frame,
                                                  const safety_area::Pipeline::Result& result,
                                                  double body_radius) {
  visualization_msgs::MarkerArray markers;
  markers.markers.resize(1);
  markers.markers[0].header = laser_header;
  markers.markers[0].action = visualization_msgs::Marker::DELETEALL;
  int id = 0;
  for (const auto& area : result.areas) {
    auto disc =
        cylinder(laser_header, "safety_areas", id++, {area.x, area.y, 0.0}, area.radius, 0.02);
    disc.color.g = 1.0F;
    disc.color.a = 0.3F;
    markers.markers.push_back(disc);
  }
  std_msgs::Header fixed_header = laser_header;
  fixed_header.frame_id = fixed_frame;
  for (const auto& person : result.persons) {
    const double height = person.height > 0.0 ? person.height : 1.7;
    auto body =
        cylinder(fixed_header, "persons", id++,
                 person.position + Eigen::Vector3d(0, 0, height / 2.0), body_radius, height);
    body.color.r = body.color.g = 1.0F;
    body.color.a = 0.35F;
    markers.markers.push_back(body);
  }
  return markers;
}

}  // namespace safe_passage
