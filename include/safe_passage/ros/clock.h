// Clock jumps, as a bag that starts over makes them.
#pragma once

#include <ros/ros.h>

namespace safe_passage {

class JumpDetector {
 public:
  // True when the clock went back since the last call: what was remembered has no meaning any more.
  // A few milliseconds are no jump: wall clocks are set back by so much, and no person leaves then.
  bool jumped_back(const ros::Time& now) {
    const bool jumped = !last_.isZero() && now.toSec() < last_.toSec() - kSlew;
    last_ = now;
    return jumped;
  }

 private:
  static constexpr double kSlew = 0.1;  // [s]
  ros::Time last_;
};

}  // namespace safe_passage
