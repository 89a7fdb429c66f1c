// Load for safety_area_merger: scans, persons and tf at given rates; what comes back is timed.
//   merger_load [--seconds S] [--rate HZ] [--beams N] [--persons N]
// Prints one line of JSON: scans sent and received, latency in ms.
#include <ros/ros.h>
#include <safe_passage/PersonArray.h>
#include <sensor_msgs/LaserScan.h>
#include <tf2_ros/static_transform_broadcaster.h>
#include <tf2_ros/transform_broadcaster.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace {

using Clock = std::chrono::steady_clock;

struct Options {
  double seconds = 20.0;  // [s]
  double rate = 40.0;     // [Hz]
  int beams = 1081;
  int persons = 50;
};

Options parse(int argc, char** argv) {
  Options options;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string name = argv[i];
    if (name == "--seconds") options.seconds = std::stod(argv[i + 1]);
    if (name == "--rate") options.rate = std::stod(argv[i + 1]);
    if (name == "--beams") options.beams = std::stoi(argv[i + 1]);
    if (name == "--persons") options.persons = std::stoi(argv[i + 1]);
  }
  return options;
}

geometry_msgs::TransformStamped transform(const std::string& parent, const std::string& child,
                                          double x) {
  geometry_msgs::TransformStamped message;
  message.header.stamp = ros::Time::now();
  message.header.frame_id = parent;
  message.child_frame_id = child;
  message.transform.translation.x = x;
  message.transform.rotation.w = 1.0;
  return message;
}

double milliseconds(Clock::duration duration) {
  return std::chrono::duration<double, std::milli>(duration).count();
}

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

class Load {
 public:
  explicit Load(const Options& options) : options_(options) {
    scan_.header.frame_id = "laser";
    scan_.angle_min = -2.356194F;  // the paper's Hokuyo UST-20LX: 270 degrees, 20 m
    scan_.angle_max = 2.356194F;
    scan_.angle_increment =
        (scan_.angle_max - scan_.angle_min) / static_cast<float>(options.beams - 1);
    scan_.range_min = 0.06F;
    scan_.range_max = 20.0F;
    scan_.ranges.assign(static_cast<std::size_t>(options.beams), 15.0F);
    scan_.intensities.assign(static_cast<std::size_t>(options.beams), 100.0F);
    scan_pub_ = node_.advertise<sensor_msgs::LaserScan>("scan", 100);
    persons_pub_ = node_.advertise<safe_passage::PersonArray>("persons", 10);
    merged_sub_ = node_.subscribe("scan_human_aware", 1000, &Load::on_merged, this,
                                  ros::TransportHints().tcpNoDelay());
    fixed_tf_.sendTransform(std::vector<geometry_msgs::TransformStamped>{
        transform("base_link", "laser", 0.2), transform("base_link", "camera", 0.1)});
    tf_timer_ = node_.createWallTimer(ros::WallDuration(0.02), [this](const ros::WallTimerEvent&) {
      tf_.sendTransform(transform("odom", "base_link", 0.0));
    });
    persons_timer_ = node_.createWallTimer(
        ros::WallDuration(0.05), [this](const ros::WallTimerEvent&) { publish_persons(); });
  }

  // False when nothing comes back.
  bool wait_for_node() {
    ros::WallRate rate(options_.rate);
    for (int i = 0; ros::ok() && i < 20.0 * options_.rate; ++i, rate.sleep()) {
      publish_scan();
      std::lock_guard<std::mutex> lock(mutex_);
      if (with_areas_ > options_.rate) return true;  // a second of it is the warm-up
    }
    return false;
  }

  void measure() {
    {
      std::lock_guard<std::mutex> lock(mutex_);
      measuring_from_ = ros::Time::now();
      with_areas_ = 0;
    }
    const auto count = static_cast<long>(options_.seconds * options_.rate);
    const auto start = Clock::now();
    while (ros::ok() && sent_ < count) {
      const auto due =
          start + std::chrono::duration_cast<Clock::duration>(
                      std::chrono::duration<double>(static_cast<double>(sent_) / options_.rate));
      std::this_thread::sleep_until(due);
      wake_ups_.push_back(milliseconds(Clock::now() - due));
      publish_scan();
      if (++sent_ % static_cast<long>(10.0 * options_.rate) == 0)
        std::fprintf(stderr, "%ld of %ld scans\n", sent_, count);
    }
    for (int i = 0; i < 20 && received() < sent_; ++i) ros::WallDuration(0.1).sleep();
  }

  // wake_p99_ms is the machine's own lateness in waking a sleeping thread: it is no better than
  // that.
  void print() {
    std::lock_guard<std::mutex> lock(mutex_);
    std::printf(
        "{\"sent\": %ld, \"received\": %zu, \"with_areas\": %ld, \"p50_ms\": %.4f, "
        "\"p99_ms\": %.4f, \"max_ms\": %.4f, \"wake_p99_ms\": %.4f}\n",
        sent_, latencies_.size(), with_areas_, quantile(latencies_, 0.5),
        quantile(latencies_, 0.99), quantile(latencies_, 1.0), quantile(wake_ups_, 0.99));
  }

 private:
  long received() {
    std::lock_guard<std::mutex> lock(mutex_);
    return static_cast<long>(latencies_.size());
  }

  void publish_scan() {
    scan_.header.stamp = ros::Time::now();
    {
      std::lock_guard<std::mutex> lock(mutex_);
      departures_[scan_.header.stamp] = Clock::now();
    }
    scan_pub_.publish(scan_);
  }

  // All around, 2 to 6 m away.
  void publish_persons() {
    safe_passage::PersonArray array;
    array.header.frame_id = "camera";
    array.header.stamp = ros::Time::now();
    for (int i = 0; i < options_.persons; ++i) {
      safe_passage::Person person;
      const double bearing = 2.0 * M_PI * i / options_.persons;
      const double distance = 2.0 + 4.0 * ((i * 7) % options_.persons) / options_.persons;
      person.id = static_cast<std::uint32_t>(i + 1);
      person.position.x = distance * std::cos(bearing);
      person.position.y = distance * std::sin(bearing);
      person.velocity.x = person.velocity.y = person.velocity.z = std::nan("");
      person.height = 1.7F;
      array.persons.push_back(person);
    }
    persons_pub_.publish(array);
  }

  void on_merged(const sensor_msgs::LaserScan::ConstPtr& merged) {
    const auto arrival = Clock::now();
    std::lock_guard<std::mutex> lock(mutex_);
    const auto departure = departures_.find(merged->header.stamp);
    if (departure == departures_.end()) return;
    if (merged->ranges[merged->ranges.size() / 2] < 10.0F) ++with_areas_;
    if (!measuring_from_.isZero() && merged->header.stamp >= measuring_from_)
      latencies_.push_back(milliseconds(arrival - departure->second));
    departures_.erase(departure);
  }

  Options options_;
  ros::NodeHandle node_;
  sensor_msgs::LaserScan scan_;
  long sent_ = 0;

  std::mutex mutex_;
  std::map<ros::Time, Clock::time_point> departures_;
  ros::Time measuring_from_;
  std::vector<double> latencies_, wake_ups_;  // [ms]
  long with_areas_ = 0;

  tf2_ros::TransformBroadcaster tf_;
  tf2_ros::StaticTransformBroadcaster fixed_tf_;
  ros::Publisher scan_pub_, persons_pub_;
  ros::Subscriber merged_sub_;
  ros::WallTimer tf_timer_, persons_timer_;
};

}  // namespace

int main(int argc, char** argv) {
  ros::init(argc, argv, "merger_load");
  Load load(parse(argc, argv));
  ros::AsyncSpinner spinner(2);
  spinner.start();
  if (!load.wait_for_node()) {
    std::fprintf(stderr, "no merged scan with areas came back\n");
    return 1;
  }
  load.measure();
  spinner.stop();
  load.print();
  return 0;
}
