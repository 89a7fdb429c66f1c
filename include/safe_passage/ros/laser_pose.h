// The laser's pose at a scan's time, without waiting for it.
#pragma once

#include <tf2/buffer_core.h>

#include <cmath>
#include <optional>
#include <string>

#include "safe_passage/ros/safety_area_messages.h"
#include "safe_passage/safety_area/pipeline.h"

namespace safe_passage {

// The exact pose, or the newest one with its age; none when the frames are not connected at all.
inline std::optional<safety_area::LaserPose> find_laser_pose(const tf2::BufferCore& buffer,
                                                             const std::string& laser_frame,
                                                             const std::string& fixed_frame,
                                                             const ros::Time& time) {
  const ros::Time newest(0);
  for (const ros::Time& wanted : {time, newest}) {
    try {
      const auto T = buffer.lookupTransform(tf_name(laser_frame), fixed_frame, wanted);
      const double age = wanted == newest ? std::abs(time.toSec() - T.header.stamp.toSec()) : 0.0;
      return safety_area::LaserPose{to_isometry(T.transform), age};
    } catch (const tf2::TransformException&) {
      // The next one is tried; the caller counts that nothing was found.
    }
  }
  return std::nullopt;
}

}  // namespace safe_passage
