#include "safe_passage/safety_area/person_memory.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace safe_passage::safety_area {
namespace {

constexpr int kLeastHits = 2;       // of a laser on a person
constexpr double kStance = 0.15;    // [m] legs of who has not moved are so near
constexpr double kLegDepth = 0.07;  // [m] from a leg's surface to the body's middle
constexpr std::size_t kNobody = std::numeric_limits<std::size_t>::max();

Eigen::Vector3d believable(const Eigen::Vector3d& velocity, double max_speed) {
  if (!velocity.allFinite()) return Eigen::Vector3d::Zero();
  const double speed = velocity.norm();
  return speed > max_speed ? Eigen::Vector3d(velocity * (max_speed / speed)) : velocity;
}

bool same_tracker(const Person& a, const Person& b) {
  return a.id != 0 && b.id != 0 && a.source == b.source;
}

}  // namespace

Eigen::Vector3d PersonMemory::position_at(const Person& person, double time) const {
  const double ahead = std::clamp(time - person.stamp, -params_.hold_time, params_.hold_time);
  return person.position + person.velocity * ahead;
}

// For each one seen the index of the person it replaces. By id first, then nearest pairs first.
std::vector<std::size_t> PersonMemory::match(const std::vector<Person>& seen) const {
  std::vector<std::size_t> matches(seen.size(), kNobody);
  std::vector<bool> taken(persons_.size(), false);
  std::vector<std::tuple<double, std::size_t, std::size_t>> pairs;
  for (std::size_t s = 0; s < seen.size(); ++s) {
    for (std::size_t p = 0; p < persons_.size(); ++p) {
      const bool tracked = same_tracker(seen[s], persons_[p]);
      if (tracked && seen[s].id != persons_[p].id) continue;
      const double distance =
          tracked ? -1.0 : (position_at(persons_[p], seen[s].stamp) - seen[s].position).norm();
      if (distance <= params_.gate) pairs.emplace_back(distance, s, p);
    }
  }
  std::sort(pairs.begin(), pairs.end());
  for (const auto& [distance, s, p] : pairs) {
    if (matches[s] != kNobody || taken[p]) continue;
    matches[s] = p;
    taken[p] = true;
  }
  return matches;
}

PersonMemory::Update PersonMemory::update(const std::vector<Person>& seen) {
  Update result;
  std::vector<Person> usable;
  for (Person person : seen) {
    if (!person.position.allFinite() || !std::isfinite(person.stamp)) {
      ++result.not_finite;
      continue;
    }
    person.velocity = believable(person.velocity, params_.max_person_speed);
    person.seen = person.stamp;
    usable.push_back(person);
  }

  const auto matches = match(usable);
  for (std::size_t s = 0; s < usable.size(); ++s) {
    if (matches[s] == kNobody) {
      persons_.push_back(usable[s]);
    } else if (usable[s].stamp < persons_[matches[s]].seen) {
      // Of another source: a camera's detection comes later than the lidars' track of the person.
      if (usable[s].source == persons_[matches[s]].source) ++result.out_of_order;
    } else {
      persons_[matches[s]] = usable[s];
    }
  }

  std::sort(persons_.begin(), persons_.end(),
            [](const Person& a, const Person& b) { return a.stamp > b.stamp; });
  while (!persons_.empty() && persons_.back().stamp < persons_.front().stamp - params_.hold_time)
    persons_.pop_back();
  if (persons_.size() > params_.max_persons) {
    result.forgotten = static_cast<int>(persons_.size() - params_.max_persons);
    persons_.resize(params_.max_persons);
  }
  return result;
}

void PersonMemory::follow(const std::vector<Eigen::Vector2d>& hits, const Eigen::Vector2d& laser,
                          double time) {
  for (Person& person : persons_) {
    const bool held = time - person.stamp <= params_.hold_time;
    if (!held || time <= person.stamp || time - person.seen > params_.laser_hold_time) continue;
    const Eigen::Vector2d expected = position_at(person, time).head<2>();
    Eigen::Vector2d sum(0.0, 0.0);
    int count = 0, still = 0;
    for (const Eigen::Vector2d& hit : hits) {
      const double apart = (hit - expected).norm();
      if (apart > params_.laser_gate) continue;
      sum += hit;
      ++count;
      if (apart <= kStance) ++still;
    }
    if (count < kLeastHits) continue;
    person.position.head<2>() = expected;
    if (still < kLeastHits) {  // who stands is not moved: what is behind would draw it away
      // The laser meets the near side of the legs.
      const Eigen::Vector2d found = sum / count + kLegDepth * (expected - laser).normalized();
      const double most = params_.max_person_speed * (time - person.stamp);
      const Eigen::Vector2d moved = found - expected;
      person.position.head<2>() += moved * std::min(1.0, most / (moved.norm() + 1e-9));
    }
    person.stamp = time;
  }
}

std::vector<Person> PersonMemory::at(double time) const {
  std::vector<Person> held;
  for (Person person : persons_) {
    if (time - person.stamp > params_.hold_time) continue;
    person.position = position_at(person, time);
    held.push_back(person);
  }
  return held;
}

}  // namespace safe_passage::safety_area
