// Clock jumps, as a bag that starts over makes them.
#pragma once

#include <ros/ros.h>

namespace safe_passage {

class JumpDetector {
 public:
  // True when the clock went back since the last call: what was remembered has no meaning any more.
  bool jumped_back(const ros::Time& now) {
    const bool jumped = !last_.isZero() && now < last_;
    last_ = now;
    return jumped;
  }

 private:
  ros::Time last_;
};

}  // namespace safe_passage
