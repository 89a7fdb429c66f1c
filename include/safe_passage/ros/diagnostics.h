// What every node reports in /diagnostics: what it waits for, rate, latency, drops by reason.
#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/ros.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <mutex>
#include <string>

namespace safe_passage {

// What became of an incoming message. Everything but kOk is a drop (or a fall-back) with a reason.
enum class Outcome {
  kOk,
  kStale,
  kFuture,
  kOutOfOrder,
  kCrowdedOut,  // newer ones came before the node had time for it
  kNoPartner,   // the camera's other messages of that time
  kNoTf,
  kEmpty,
  kBadFields,
  kNotFinite
};

inline const char* to_string(Outcome outcome) {
  static const char* const kNames[] = {"OK",          "STALE",      "FUTURE", "OUT_OF_ORDER",
                                       "CROWDED_OUT", "NO_PARTNER", "NO_TF",  "EMPTY",
                                       "BAD_FIELDS",  "NOT_FINITE"};
  return kNames[static_cast<int>(outcome)];
}

// By how much a stamp is off, for STALE and FUTURE: it tells which clock is wrong.
inline std::string said_age(double age) {
  char text[40];
  std::snprintf(text, sizeof text, "%.3f s %s", std::abs(age), age < 0.0 ? "ahead" : "old");
  return text;
}

class NodeDiagnostics {
  static constexpr double kTellAgain = 5.0;  // [s] of the wall between two warnings of an input

 public:
  // `timeout` [s]: an input silent, or without one usable message, for longer is an error.
  explicit NodeDiagnostics(double timeout) : timeout_(timeout), started_(ros::WallTime::now()) {
    updater_.setHardwareID("none");
    updater_.add("inputs", this, &NodeDiagnostics::report_inputs);
    // By force: update() obeys ROS time, and a paused or rewound clock must not silence it.
    const double period = ros::param::param("~diagnostic_period", 1.0);
    timer_ = ros::NodeHandle().createWallTimer(
        ros::WallDuration(std::clamp(period, 0.05, 60.0)),
        [this](const ros::WallTimerEvent&) { updater_.force_update(); });
  }

  void expect(const std::string& input) {
    std::lock_guard<std::mutex> lock(mutex_);
    inputs_[input].expected = true;
  }

  void count(const std::string& input, Outcome outcome, const std::string& detail = "") {
    bool tell = false;  // by hand: ROS_WARN_THROTTLE is not made for several threads
    {
      std::lock_guard<std::mutex> lock(mutex_);
      Input& entry = inputs_[input];
      ++entry.outcomes[outcome];
      entry.last_outcome = outcome;
      entry.last_detail = detail;
      entry.last = ros::WallTime::now();
      if (outcome == Outcome::kOk) entry.last_ok = entry.last;
      tell = outcome != Outcome::kOk && (entry.last - entry.told).toSec() >= kTellAgain;
      if (tell) entry.told = entry.last;
    }
    if (tell) ROS_WARN("%s: %s %s", input.c_str(), to_string(outcome), detail.c_str());
  }

  // [s] from the input's arrival to the output's publication.
  void latency(double seconds) {
    std::lock_guard<std::mutex> lock(mutex_);
    worst_latency_ = std::max(worst_latency_, seconds);
    ++outputs_;
  }

  using Check = std::function<void(diagnostic_updater::DiagnosticStatusWrapper&)>;
  void add_check(const std::string& name, Check check) { updater_.add(name, std::move(check)); }

 private:
  struct Input {
    bool expected = false;
    std::map<Outcome, unsigned long> outcomes;
    Outcome last_outcome = Outcome::kOk;
    std::string last_detail;
    ros::WallTime last, last_ok, told;
  };

  // What is wrong with an input; empty: nothing. Those nobody expects may be silent.
  std::string fault_of(const std::string& name, const Input& input,
                       const ros::WallTime& now) const {
    const auto long_since = [&](const ros::WallTime& time) {
      return (now - (time.isZero() ? started_ : time)).toSec() > timeout_;
    };
    if (!long_since(input.last_ok)) return "";
    const bool by_clock =
        input.last_outcome == Outcome::kStale || input.last_outcome == Outcome::kFuture;
    const std::string by = by_clock && !input.last_detail.empty() ? ", " + input.last_detail : "";
    if (!long_since(input.last) && !input.last.isZero())
      return name + ": only dropped messages, last reason " + to_string(input.last_outcome) + by;
    if (!input.expected || !long_since(input.last)) return "";
    return (input.last.isZero() ? "waiting for " : "silent: ") + name;
  }

  void report_inputs(diagnostic_updater::DiagnosticStatusWrapper& status) {
    std::lock_guard<std::mutex> lock(mutex_);
    const ros::WallTime now = ros::WallTime::now();
    const double period = std::max((now - reported_).toSec(), 1e-3);
    status.summary(diagnostic_msgs::DiagnosticStatus::OK, "all inputs alive");
    for (const auto& [name, input] : inputs_) {
      const std::string fault = fault_of(name, input, now);
      if (!fault.empty()) status.mergeSummary(diagnostic_msgs::DiagnosticStatus::ERROR, fault);
      for (const auto& [outcome, count] : input.outcomes)
        status.add(name + " " + to_string(outcome), count);
    }
    status.addf("output rate [Hz]", "%.2f", reported_.isZero() ? 0.0 : outputs_ / period);
    status.addf("worst latency [ms]", "%.2f", worst_latency_ * 1e3);
    outputs_ = 0;
    worst_latency_ = 0.0;
    reported_ = now;
  }

  double timeout_;
  ros::WallTime started_, reported_;
  std::mutex mutex_;
  std::map<std::string, Input> inputs_;
  unsigned long outputs_ = 0;
  double worst_latency_ = 0.0;
  diagnostic_updater::Updater updater_;
  ros::WallTimer timer_;
};

}  // namespace safe_passage
