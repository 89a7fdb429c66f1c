// Node person_detector: RGB-D in, persons out. Converts, calls the detector, publishes.
//
// Frames come in by a thread of their own, so that one that came before the detector had time for it
// gives way to the newest, and is counted.
#include <cv_bridge/cv_bridge.h>
#include <message_filters/subscriber.h>
#include <message_filters/sync_policies/approximate_time.h>
#include <message_filters/synchronizer.h>
#include <ros/ros.h>
#include <tf2_ros/transform_listener.h>

#include <algorithm>
#include <deque>
#include <iterator>
#include <opencv2/core.hpp>

#include "safe_passage/person_detection/debug_image.h"
#include "safe_passage/person_detection/frame_io.h"
#include "safe_passage/ros/clock.h"
#include "safe_passage/ros/detector_parameters.h"
#include "safe_passage/ros/diagnostics.h"
#include "safe_passage/ros/live_tuning.h"
#include "safe_passage/ros/newest_work.h"
#include "safe_passage/ros/person_conversions.h"

namespace safe_passage::person_detection {

constexpr int kLeastVoxels = 100;       // with fewer the camera is covered: it cannot say "nobody"
constexpr double kLeastContrast = 1.0;  // [grey levels] standard deviation, see shows_something()
constexpr std::size_t kQueue = 15;  // of each topic: a self-filter makes depth later than colours
constexpr double kMaxSpread = 0.1;  // [s] between depth and colours: people move on

// Not of one colour, as where the colour sensor fails or its lens is covered while depth goes on:
// in such a picture everybody would be scored as nobody.
bool shows_something(const cv::Mat& bgr) {
  if (bgr.empty()) return true;  // what has no pixels is refused for that
  cv::Scalar mean, deviation;
  cv::meanStdDev(bgr, mean, deviation);
  return std::max({deviation[0], deviation[1], deviation[2]}) >= kLeastContrast;
}

class PersonDetectorNode {
 public:
  PersonDetectorNode()
      : private_node_("~"),
        tuning_(private_node_, read_parameters, kLiveParameters,
                [this](const DetectorNodeParameters& tuned) { tune(tuned); }),
        parameters_(tuning_.parameters()),
        detector_(parameters_.detector),
        diagnostics_(parameters_.input_timeout),
        tf_listener_(tf_) {
    intake_node_.setCallbackQueue(&intake_queue_);
    persons_pub_ = node_.advertise<PersonArray>("persons", 1);
    markers_pub_ = private_node_.advertise<visualization_msgs::MarkerArray>("markers", 1);
    debug_pub_ = private_node_.advertise<sensor_msgs::Image>("debug_image", 1);
    if (parameters_.input == "cloud")
      subscribe_cloud();
    else
      subscribe_depth();
    diagnostics_.add_check("ground", [this](auto& status) { report_ground(status); });
    tuning_.serve();
    intake_spinner_.start();
  }

 private:
  // Between two frames: all callbacks but the intake's run in one thread. Ground and camera stay.
  void tune(const DetectorNodeParameters& tuned) {
    parameters_ = tuned;
    detector_.tune(tuned.detector);
  }

  void subscribe_cloud() {
    cloud_sub_ = intake_node_.subscribe<sensor_msgs::PointCloud2>(
        "depth_registered/points", kQueue, [this](const sensor_msgs::PointCloud2ConstPtr& cloud) {
          work_.put([this, cloud, arrived = ros::WallTime::now()] { on_cloud(cloud, arrived); });
        });
    info_sub_ = node_.subscribe("rgb/camera_info", 1, &PersonDetectorNode::on_info, this);
    expect(cloud_sub_.getTopic());
  }

  void subscribe_depth() {
    rgb_sub_.subscribe(intake_node_, "rgb/image_rect_color", kQueue);
    depth_sub_.subscribe(intake_node_, "depth_registered/image_rect", kQueue);
    info_filter_.subscribe(intake_node_, "rgb/camera_info", kQueue);
    depth_sub_.registerCallback(&PersonDetectorNode::take_depth, this);  // before sync_ has it
    sync_.setMaxIntervalDuration(ros::Duration(kMaxSpread));
    sync_.connectInput(depth_sub_, rgb_sub_, info_filter_);
    sync_.registerCallback(&PersonDetectorNode::take_images, this);
    expect(depth_sub_.getTopic() + " + " + rgb_sub_.getTopic() + " + " + info_filter_.getTopic());
  }

  void expect(const std::string& input) {
    input_ = input;
    diagnostics_.expect(input);
    ROS_INFO("waiting for %s", input.c_str());
  }

  // Uncalibrated cameras send zeros (as CameraInfo.msg has it): nobody would be found with them.
  void on_info(const sensor_msgs::CameraInfo& info) {
    const Intrinsics camera = to_intrinsics(info);
    const bool calibrated = camera.fx > 0.0 && camera.fy > 0.0;
    if (calibrated) camera_ = camera;
    diagnostics_.count(info_sub_.getTopic(), calibrated ? Outcome::kOk : Outcome::kBadFields);
  }

  void on_cloud(const sensor_msgs::PointCloud2ConstPtr& cloud, ros::WallTime arrived) {
    if (!in_time(cloud->header)) return;
    const std::string fault = fault_of(*cloud);
    if (!fault.empty()) return diagnostics_.count(input_, Outcome::kBadFields, fault);
    RgbdFrame frame = to_frame(*cloud);
    try {
      // Without camera info the cloud itself tells its camera, once for all its frames.
      if (!camera_) camera_ = estimate_intrinsics(frame.xyz);
    } catch (const std::runtime_error& error) {
      return diagnostics_.count(input_, Outcome::kEmpty, error.what());
    }
    frame.camera = *camera_;
    process(frame, cloud->header, arrived);
  }

  void take_depth(const sensor_msgs::ImageConstPtr& depth) {
    unpaired_.push_back(depth->header.stamp);
    if (unpaired_.size() <= kQueue) return;
    unpaired_.pop_front();  // sync_ has dropped it
    ++passed_over_;
  }

  // Told when there are colours again: until then it is their silence that is reported.
  void tell_passed_over(const ros::Time& paired) {
    const auto found = std::find(unpaired_.begin(), unpaired_.end(), paired);
    if (found == unpaired_.end()) return;
    passed_over_ += std::distance(unpaired_.begin(), found);
    unpaired_.erase(unpaired_.begin(), std::next(found));
    for (; passed_over_ > 0; --passed_over_)
      diagnostics_.count(input_, Outcome::kNoPartner, "no colours of a depth image's time");
  }

  void take_images(const sensor_msgs::ImageConstPtr& depth, const sensor_msgs::ImageConstPtr& rgb,
                   const sensor_msgs::CameraInfoConstPtr& info) {
    tell_passed_over(depth->header.stamp);
    work_.put([this, depth, rgb, info, arrived = ros::WallTime::now()] {
      on_images(depth, rgb, info, arrived);
    });
  }

  void on_images(const sensor_msgs::ImageConstPtr& depth, const sensor_msgs::ImageConstPtr& rgb,
                 const sensor_msgs::CameraInfoConstPtr& info, ros::WallTime arrived) {
    if (!in_time(depth->header)) return;
    const std::string fault = fault_of(*depth, *rgb, *info);
    if (!fault.empty()) return diagnostics_.count(input_, Outcome::kBadFields, fault);
    try {
      const auto bgr = cv_bridge::toCvShare(rgb, "bgr8");
      process(from_depth(cv_bridge::toCvShare(depth)->image, bgr->image, to_intrinsics(*info)),
              depth->header, arrived);
    } catch (const std::exception& error) {  // cv_bridge's and from_depth's: encodings, sizes
      diagnostics_.count(input_, Outcome::kBadFields, error.what());
    }
  }

  // Counts and refuses what is too old, from the future, or without a frame.
  bool in_time(const std_msgs::Header& header) {
    const ros::Time now = ros::Time::now();
    if (jump_.jumped_back(now)) {
      ROS_WARN("clock went back: forgetting the ground");
      detector_.reset();
      tf_.clear();
    }
    const double age = (now - header.stamp).toSec();
    if (age > parameters_.max_age)
      diagnostics_.count(input_, Outcome::kStale, said_age(age));
    else if (age < -parameters_.max_future)
      diagnostics_.count(input_, Outcome::kFuture, said_age(age));
    else if (header.frame_id.empty())
      diagnostics_.count(input_, Outcome::kBadFields, "no frame_id");
    else
      return true;
    return false;
  }

  // By wall time: tf2_ros' own timeout does not end while a simulated clock stands still.
  void wait_for_transform(const std_msgs::Header& header) const {
    const ros::WallTime end = ros::WallTime::now() + ros::WallDuration(parameters_.tf_timeout);
    while (!tf_.canTransform(header.frame_id, parameters_.ground_frame, header.stamp) &&
           ros::WallTime::now() < end && ros::ok())
      ros::WallDuration(0.002).sleep();
  }

  std::optional<GroundPlane> ground_seed(const std_msgs::Header& header) {
    if (parameters_.ground_seed) return parameters_.ground_seed;
    wait_for_transform(header);
    try {
      const auto T =
          tf_.lookupTransform(header.frame_id, parameters_.ground_frame, header.stamp).transform;
      diagnostics_.count("tf", Outcome::kOk);
      return to_ground_plane(T);
    } catch (const tf2::TransformException& error) {
      diagnostics_.count("tf", Outcome::kNoTf, error.what());
      return std::nullopt;  // the tracked ground serves on; without one nothing is published
    }
  }

  void process(const RgbdFrame& frame, const std_msgs::Header& header, ros::WallTime arrived) {
    if (!shows_something(frame.bgr))
      return diagnostics_.count(input_, Outcome::kEmpty, "the picture is of one colour");
    // Another camera's ground is not this one's.
    if (header.frame_id != frame_id_) detector_.reset();
    frame_id_ = header.frame_id;
    const DetectionResult result = detector_.detect(frame, ground_seed(header));
    ground_state_ = result.ground.state;
    if (result.voxels < kLeastVoxels)
      return diagnostics_.count(input_, Outcome::kEmpty, "hardly a finite point");
    // Silence: an empty array would say that nobody is there.
    if (ground_state_ == GroundState::kUnknown)
      return diagnostics_.count(input_, Outcome::kNoTf,
                                "no ground known: waiting for tf from " + header.frame_id + " to " +
                                    parameters_.ground_frame + ", or set ground_seed");
    persons_pub_.publish(to_message(result, parameters_.detector.method, header));
    diagnostics_.count(input_, Outcome::kOk);
    diagnostics_.latency((ros::WallTime::now() - arrived).toSec());
    if (markers_pub_.getNumSubscribers() > 0) markers_pub_.publish(to_markers(result, header));
    if (debug_pub_.getNumSubscribers() > 0)
      debug_pub_.publish(
          cv_bridge::CvImage(header, "bgr8", draw_debug(frame.bgr, result)).toImageMsg());
  }

  void report_ground(diagnostic_updater::DiagnosticStatusWrapper& status) {
    static const char* const kNames[] = {"tracked", "not seen, last estimate in use", "unknown"};
    status.summary(static_cast<unsigned char>(ground_state_),
                   kNames[static_cast<int>(ground_state_)]);
  }

  ros::NodeHandle node_, private_node_, intake_node_;
  ros::CallbackQueue intake_queue_;
  LiveTuning<DetectorNodeParameters> tuning_;
  DetectorNodeParameters parameters_;
  PersonDetector detector_;
  NodeDiagnostics diagnostics_;
  JumpDetector jump_;
  tf2_ros::Buffer tf_;
  tf2_ros::TransformListener tf_listener_;
  std::string input_, frame_id_;
  std::optional<Intrinsics> camera_;
  GroundState ground_state_ = GroundState::kUnknown;
  ros::Publisher persons_pub_, markers_pub_, debug_pub_;
  ros::Subscriber cloud_sub_, info_sub_;
  message_filters::Subscriber<sensor_msgs::Image> rgb_sub_, depth_sub_;
  message_filters::Subscriber<sensor_msgs::CameraInfo> info_filter_;
  using Policy =
      message_filters::sync_policies::ApproximateTime<sensor_msgs::Image, sensor_msgs::Image,
                                                      sensor_msgs::CameraInfo>;
  message_filters::Synchronizer<Policy> sync_{Policy(kQueue)};
  std::deque<ros::Time> unpaired_;  // stamps of depth images, oldest first
  std::size_t passed_over_ = 0;     // of them, not told yet
  NewestWork work_{[this] {
    diagnostics_.count(input_, Outcome::kCrowdedOut, "a newer one came before its turn");
  }};
  ros::AsyncSpinner intake_spinner_{1, &intake_queue_};  // last: it ends first
};

}  // namespace safe_passage::person_detection

int main(int argc, char** argv) {
  ros::init(argc, argv, "person_detector");
  const ros::NodeHandle keeps_ros_up;  // when the last handle goes, errors are logged no more
  try {
    safe_passage::person_detection::PersonDetectorNode node;
    ros::spin();
  } catch (const std::exception& error) {
    ROS_FATAL("%s", error.what());
    return 1;
  }
  return 0;
}
