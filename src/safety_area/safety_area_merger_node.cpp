// Node safety_area_merger: scan, persons, tracked_persons -> scan_human_aware, ~safety_scan,
// ~markers, /diagnostics.
//
// Scans have a thread of their own and never wait for tf: what a late transform leaves unknown
// about the robot's motion widens the areas. Persons wait for the transform of their own stamp.
#include <ros/callback_queue.h>
#include <tf2/buffer_core.h>
#include <tf2_ros/transform_listener.h>

#include <cmath>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "safe_passage/ros/clock.h"
#include "safe_passage/ros/diagnostics.h"
#include "safe_passage/ros/laser_pose.h"
#include "safe_passage/ros/live_tuning.h"
#include "safe_passage/ros/safety_area_messages.h"
#include "safe_passage/ros/safety_area_parameters.h"
#include "safe_passage/safety_area/pipeline.h"

namespace safe_passage {
namespace {

constexpr std::size_t kMaxPending = 50;  // person arrays waiting for tf

struct Pending {
  std::string topic;
  PersonArray::ConstPtr array;
};

class SafetyAreaMerger {
 public:
  SafetyAreaMerger() {
    ros::NodeHandle node, scan_node, private_node("~");
    scan_node.setCallbackQueue(&scan_queue_);
    merged_pub_ = node.advertise<sensor_msgs::LaserScan>("scan_human_aware", 100);
    safety_pub_ = private_node.advertise<sensor_msgs::LaserScan>("safety_scan", 10);
    markers_pub_ = private_node.advertise<visualization_msgs::MarkerArray>("markers", 2);
    diagnostics_.expect("scan");
    diagnostics_.expect("persons");
    diagnostics_.add_check("safety areas", [this](auto& status) { report(status); });

    const auto hints = ros::TransportHints().tcpNoDelay();
    scan_sub_ = scan_node.subscribe("scan", 100, &SafetyAreaMerger::on_scan, this, hints);
    persons_sub_ = node.subscribe<PersonArray>(
        "persons", 20,
        [this](const PersonArray::ConstPtr& in) {
          saw_persons();
          on_persons("persons", in);
        },
        ros::VoidConstPtr(), hints);
    // Of the obstacle tracker, where one runs: its silence is no fault of this node.
    tracked_sub_ = node.subscribe<PersonArray>(
        "tracked_persons", 20,
        [this](const PersonArray::ConstPtr& in) { on_persons("tracked_persons", in); },
        ros::VoidConstPtr(), hints);
    // Wall time: a paused simulation must not stop them.
    pending_timer_ = node.createWallTimer(
        ros::WallDuration(0.02), [this](const ros::WallTimerEvent&) { resolve_pending(); });
    markers_timer_ = node.createWallTimer(ros::WallDuration(0.1),
                                          [this](const ros::WallTimerEvent&) { show_markers(); });
    tuning_.serve();
    scan_spinner_.start();
    spinner_.start();
  }

 private:
  // Between two scans; persons stay.
  void tune(const SafetyAreaParameters& tuned) {
    const std::lock_guard<std::mutex> lock(mutex_);
    params_ = tuned;
    pipeline_.tune(tuned.pipeline);
  }

  void on_scan(const sensor_msgs::LaserScan::ConstPtr& in) {
    const ros::WallTime arrived = ros::WallTime::now();
    Outcome outcome = Outcome::kOk;
    const safety_area::Scan scan = to_scan(*in);
    std::unique_lock<std::mutex> lock(mutex_);
    const ros::Time time = merge_time(in->header.stamp, outcome);
    const auto pose = locate(in->header.frame_id, time, outcome);
    auto result = pipeline_.merge(scan, time.toSec(), pose, outline(in->header.frame_id));
    lock.unlock();
    if (result.scan.ignored > 0) outcome = Outcome::kNotFinite;
    if (result.scan.fault != safety_area::ScanFault::kNone) outcome = to_outcome(result.scan.fault);

    const auto out = boost::make_shared<sensor_msgs::LaserScan>(*in);
    out->ranges = std::move(result.scan.ranges);
    out->intensities = std::move(result.scan.intensities);
    merged_pub_.publish(out);
    diagnostics_.latency((ros::WallTime::now() - arrived).toSec());
    diagnostics_.count("scan", outcome, "frame " + in->header.frame_id);

    if (safety_pub_.getNumSubscribers() > 0) {
      const auto safety = boost::make_shared<sensor_msgs::LaserScan>(*in);
      safety->ranges = std::move(result.scan.safety_ranges);
      safety->intensities = std::move(result.scan.safety_intensities);
      safety_pub_.publish(safety);
    }
    lock.lock();
    shown_header_ = in->header;
    shown_ = std::move(result);
  }

  void saw_persons() {
    const std::lock_guard<std::mutex> lock(mutex_);
    last_persons_ = ros::WallTime::now();
  }

  void on_persons(const std::string& topic, const PersonArray::ConstPtr& in) {
    std::unique_lock<std::mutex> lock(mutex_);
    const double age = forget_if_jumped().toSec() - in->header.stamp.toSec();
    const std::string frame = "frame '" + in->header.frame_id + "'";
    if (in->header.frame_id.empty()) return diagnostics_.count(topic, Outcome::kBadFields, frame);
    if (age > hold_time()) return diagnostics_.count(topic, Outcome::kStale, said_age(age));
    if (-age > params_.future_tolerance)
      return diagnostics_.count(topic, Outcome::kFuture, said_age(age));
    if (in->persons.empty()) return diagnostics_.count(topic, Outcome::kOk);
    if (pending_.size() == kMaxPending) {
      diagnostics_.count(pending_.front().topic, Outcome::kNoTf, frame);
      pending_.pop_front();
    }
    pending_.push_back({topic, in});
    lock.unlock();
    resolve_pending();
  }

  // Persons go to the fixed frame by the transform of their own stamp, which often comes later.
  void resolve_pending() {
    std::lock_guard<std::mutex> lock(mutex_);
    const double now = forget_if_jumped().toSec();
    std::deque<Pending> waiting;
    for (const auto& [topic, array] : pending_) {
      const std::string frame = tf_name(array->header.frame_id);
      try {
        const auto T =
            buffer_.lookupTransform(params_.fixed_frame, frame, array->header.stamp).transform;
        remember(topic, to_persons(*array, to_isometry(T)));
      } catch (const tf2::TransformException& error) {
        if (now - array->header.stamp.toSec() > hold_time())
          diagnostics_.count(topic, Outcome::kNoTf, error.what());
        else
          waiting.push_back({topic, array});
      }
    }
    pending_ = std::move(waiting);
  }

  void remember(const std::string& topic, const std::vector<safety_area::Person>& persons) {
    const auto update = pipeline_.remember(persons);
    Outcome outcome = Outcome::kOk;
    if (update.forgotten > 0) outcome = Outcome::kBadFields;
    if (update.out_of_order > 0) outcome = Outcome::kOutOfOrder;
    if (update.not_finite > 0) outcome = Outcome::kNotFinite;
    diagnostics_.count(topic, outcome, update.forgotten > 0 ? "more than max_persons" : "");
  }

  // The scan's own stamp; now, where that has no meaning: persons are then still merged.
  ros::Time merge_time(const ros::Time& stamp, Outcome& outcome) {
    const ros::Time now = forget_if_jumped();
    const double age = now.toSec() - stamp.toSec();
    if (std::abs(age) <= hold_time()) return stamp;
    outcome = age > 0.0 ? Outcome::kStale : Outcome::kFuture;
    return now;
  }

  // A pose older than tf_tolerance is still used, with areas widened for it, and reported.
  std::optional<safety_area::LaserPose> locate(const std::string& frame, const ros::Time& time,
                                               Outcome& outcome) const {
    const auto pose = find_laser_pose(buffer_, frame, params_.fixed_frame, time);
    if (!pose || pose->age > params_.tf_tolerance) outcome = Outcome::kNoTf;
    return pose && pose->age <= hold_time() ? pose : std::nullopt;
  }

  // The robot's, in the laser's frame, in which it stays where it is. Empty where tf does not know:
  // then areas end at the laser, nearer than they would at the outline, never farther.
  safety_area::Outline outline(const std::string& laser_frame) const {
    safety_area::Outline corners;
    if (params_.footprint.empty()) return corners;
    try {
      const auto T = to_isometry(
          buffer_.lookupTransform(tf_name(laser_frame), params_.base_frame, ros::Time(0))
              .transform);
      for (const auto& corner : params_.footprint)
        corners.emplace_back((T * Eigen::Vector3d(corner.x(), corner.y(), 0.0)).head<2>());
    } catch (const tf2::TransformException& error) {
      ROS_WARN_THROTTLE(5.0, "areas are cut back to the laser, not to the footprint in '%s': %s",
                        params_.base_frame.c_str(), error.what());
    }
    return corners;
  }

  ros::Time forget_if_jumped() {
    const ros::Time now = ros::Time::now();
    if (clock_.jumped_back(now)) {
      ROS_WARN("the clock went back: persons and transforms are forgotten");
      pipeline_.clear();
      pending_.clear();
      buffer_.clear();
      shown_ = {};
    }
    return now;
  }

  void show_markers() {
    if (markers_pub_.getNumSubscribers() == 0) return;
    std::unique_lock<std::mutex> lock(mutex_);
    const auto header = std::exchange(shown_header_, {});  // nothing is shown twice
    const auto shown = shown_;
    const auto [frame, radius] =
        std::make_pair(params_.fixed_frame, params_.pipeline.merge.body_radius);
    lock.unlock();
    if (header.frame_id.empty()) return;
    markers_pub_.publish(to_markers(header, frame, shown, radius));
  }

  void report(diagnostic_updater::DiagnosticStatusWrapper& status) {
    std::lock_guard<std::mutex> lock(mutex_);
    const bool silent = (ros::WallTime::now() - last_persons_).toSec() > params_.input_timeout;
    const char* missing = shown_.persons.empty()
                              ? "persons silent: no safety areas"
                              : "persons silent: safety areas of those remembered or tracked";
    status.summary(
        silent ? diagnostic_msgs::DiagnosticStatus::WARN : diagnostic_msgs::DiagnosticStatus::OK,
        silent ? missing : "persons arrive");
    status.add("persons held", shown_.persons.size());
    status.add("persons arrays waiting for tf", pending_.size());
    status.add("areas merged", shown_.areas.size());
    status.add("areas the robot is in", shown_.scan.inside);
  }

  double hold_time() const { return params_.pipeline.memory.hold_time; }

  LiveTuning<SafetyAreaParameters> tuning_{
      ros::NodeHandle("~"), read_safety_area_parameters, kLiveSafetyAreaParameters,
      [this](const SafetyAreaParameters& tuned) { tune(tuned); }};
  std::mutex mutex_;                                    // guards everything from here to the shown
  SafetyAreaParameters params_ = tuning_.parameters();  // frame and time-out never change
  safety_area::Pipeline pipeline_{params_.pipeline};
  std::deque<Pending> pending_;
  JumpDetector clock_;
  ros::WallTime last_persons_;
  std_msgs::Header shown_header_;
  safety_area::Pipeline::Result shown_;

  tf2::BufferCore buffer_;
  tf2_ros::TransformListener listener_{buffer_};
  NodeDiagnostics diagnostics_{params_.input_timeout};
  ros::Publisher merged_pub_, safety_pub_, markers_pub_;
  ros::CallbackQueue scan_queue_;
  ros::Subscriber scan_sub_, persons_sub_, tracked_sub_;
  ros::WallTimer pending_timer_, markers_timer_;
  ros::AsyncSpinner scan_spinner_{1, &scan_queue_}, spinner_{1};
};

}  // namespace
}  // namespace safe_passage

int main(int argc, char** argv) {
  ros::init(argc, argv, "safety_area_merger");
  const ros::NodeHandle keeps_ros_up;  // when the last handle goes, errors are logged no more
  try {
    safe_passage::SafetyAreaMerger node;
    ros::waitForShutdown();
  } catch (const std::exception& error) {
    ROS_FATAL("%s", error.what());
    return 1;
  }
  return 0;
}
