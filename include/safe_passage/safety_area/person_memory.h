// Persons remembered in the fixed frame, so that a safety area outlives a detector's missed frames.
//
// - A detection replaces the older one of the same id (from the same source), else the nearest one
//   within the gate. One that matches nothing is a new person. Where a match is doubtful both stay:
//   a ghost for hold_time is the safe side.
// - An array without a person deletes nothing: detectors flicker. A person leaves hold_time after
//   the last detection, or after the laser last met something at its place, up to
//   laser_hold_time after the last detection: a camera does not see whom the robot passes.
// - A detection older than the one it would replace is ignored; from the same source it is out of
//   order.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace safe_passage::safety_area {

struct Person {
  std::string source;                 // ids are of this detector only
  std::uint32_t id = 0;               // 0: not tracked
  double stamp = 0.0;                 // [s] when the person was there
  double seen = 0.0;                  // [s] last detection; the laser may have met the person since
  Eigen::Vector3d position{0, 0, 0};  // [m] fixed frame, on the ground
  Eigen::Vector3d velocity{0, 0, 0};  // [m/s] fixed frame, over ground; NaN: unknown, taken as 0
  double height = 0.0;                // [m]
};

struct MemoryParameters {
  double hold_time = 1.0;         // [s] a person is kept after the last detection
  double laser_hold_time = 0.0;   // [s] after the last detection: as long the laser keeps a person
  double laser_gate = 0.35;       // [m] what the laser meets so near to a person is the person
  double gate = 0.5;              // [m] farthest a detection may lie from the person it replaces
  double max_person_speed = 3.0;  // [m/s] faster is not believed, and cut to this
  std::size_t max_persons = 200;  // when more, those longest unseen are forgotten
};

class PersonMemory {
 public:
  struct Update {
    int not_finite = 0, out_of_order = 0, forgotten = 0;  // persons
  };

  explicit PersonMemory(const MemoryParameters& params = {}) : params_(params) {}

  // Other parameters from now on; persons stay.
  void tune(const MemoryParameters& params) { params_ = params; }

  Update update(const std::vector<Person>& seen);

  // The laser met `hits` (fixed frame, on the ground) at `time`: who is there is kept, and followed.
  void follow(const std::vector<Eigen::Vector2d>& hits, const Eigen::Vector2d& laser, double time);

  // Everyone held at `time` [s], moved there by the velocity; the stamp stays the detection's.
  std::vector<Person> at(double time) const;

  void clear() { persons_.clear(); }
  std::size_t size() const { return persons_.size(); }

 private:
  std::vector<std::size_t> match(const std::vector<Person>& seen) const;
  Eigen::Vector3d position_at(const Person& person, double time) const;

  MemoryParameters params_;
  std::vector<Person> persons_;
};

}  // namespace safe_passage::safety_area
