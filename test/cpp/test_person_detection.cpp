// The person detector's stages against analytic truth.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <set>

#include "safe_passage/person_detection/box_candidates.h"
#include "safe_passage/person_detection/detector.h"
#include "safe_passage/person_detection/frame_io.h"

namespace safe_passage::person_detection {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

cv::Mat cloud_of(const std::vector<cv::Vec3f>& points) {
  return cv::Mat(1, static_cast<int>(points.size()), CV_32FC3,
                 const_cast<cv::Vec3f*>(points.data()))
      .clone();
}

Points filter(const std::vector<cv::Vec3f>& points, const VoxelParameters& parameters = {}) {
  return VoxelGrid(parameters).filter(cloud_of(points), 0.0);
}

// A level floor 1.5 m under the camera, with noise of 5 mm.
Points floor_points(int count, float height = 1.5F, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> x(-2.0F, 2.0F), z(1.5F, 6.0F);
  std::normal_distribution<float> noise(0.0F, 0.005F);
  Points points;
  for (int i = 0; i < count; ++i) points.push_back({x(random), height + noise(random), z(random)});
  return points;
}

GroundPlane level(float height) { return {{0.0F, -1.0F, 0.0F}, height}; }

// Upright cylinder surface in the ground frame, 6 cm between its points.
void add_cylinder(Points& points, float x, float y, float radius, float low, float high) {
  const int around = std::max(8, static_cast<int>(2.0 * M_PI * radius / 0.06));
  for (float z = low; z <= high; z += 0.06F) {
    for (int i = 0; i < around; ++i) {
      const double turn = 2.0 * M_PI * i / around;
      points.push_back({x + radius * static_cast<float>(std::cos(turn)),
                        y + radius * static_cast<float>(std::sin(turn)), z});
    }
  }
  points.push_back({x, y, high});
}

// Trunk and head of a person of 1.75 m.
void add_person(Points& points, float x, float y) {
  add_cylinder(points, x, y, 0.2F, 0.12F, 1.42F);
  add_cylinder(points, x, y, 0.14F, 1.42F, 1.43F);  // shoulders
  add_cylinder(points, x, y, 0.09F, 1.45F, 1.75F);
}

TEST(VoxelGrid, PutsOneCentroidInEachVoxel) {
  const Points voxels = filter({{0.01F, 0.01F, 1.21F}, {0.03F, 0.05F, 1.23F}, {0.5F, 0.0F, 1.2F}});
  ASSERT_EQ(voxels.size(), 2U);
  EXPECT_TRUE(voxels[0].isApprox(Eigen::Vector3f(0.02F, 0.03F, 1.22F), 1e-5F));
}

TEST(VoxelGrid, SeparatesVoxelsOnBothSidesOfZero) {
  EXPECT_EQ(filter({{-0.01F, 0.01F, 1.0F}, {0.01F, 0.01F, 1.0F}}).size(), 2U);
}

TEST(VoxelGrid, LeavesOutWhatIsNoPoint) {
  EXPECT_TRUE(filter({{kNan, 0.0F, 1.0F},
                      {0.0F, kNan, 1.0F},
                      {0.0F, 0.0F, kNan},
                      {kInf, 0.0F, 1.0F},
                      {0.0F, 0.0F, kInf},
                      {0.0F, 0.0F, 0.0F},
                      {0.0F, 0.0F, -1.0F},
                      {1e30F, 0.0F, 1.0F},
                      {0.0F, 0.0F, 11.0F}})
                  .empty());
}

TEST(VoxelGrid, ForgetsTheLastFrameAndGrowsWhenNeeded) {
  VoxelGrid grid{VoxelParameters{}};
  std::vector<cv::Vec3f> many;  // more voxels than the table starts with
  for (int i = 0; i < 200000; ++i)
    many.push_back({0.06F * (static_cast<float>(i % 450) + 0.5F),
                    0.06F * (static_cast<float>(i / 450) + 0.5F), 1.0F});
  EXPECT_EQ(grid.filter(cloud_of(many), 0.0).size(), many.size());
  EXPECT_EQ(grid.filter(cloud_of({{0.0F, 0.0F, 1.0F}}), 0.0).size(), 1U);
}

TEST(VoxelGrid, SamplesOnlyAsFarApartAsVoxelsAllow) {
  cv::Mat wall(480, 640, CV_32FC3);  // as far away as it looks
  for (int v = 0; v < wall.rows; ++v)
    for (int u = 0; u < wall.cols; ++u)
      wall.at<cv::Vec3f>(v, u) = {(u - 320) / 525.0F * 9.93F, (v - 240) / 525.0F * 9.93F, 9.93F};
  VoxelParameters every;
  every.sampling = 1;
  const auto all = VoxelGrid(every).filter(wall, 525.0).size();
  EXPECT_GT(VoxelGrid(VoxelParameters{}).filter(wall, 525.0).size(), 0.97 * all);
}

TEST(Ground, IsFoundFromARoughSeed) {
  GroundTracker tracker{GroundParameters{}};
  GroundPlane seed{Eigen::Vector3f(0.03F, -1.0F, 0.03F).normalized(), 1.4F};
  const auto estimate = tracker.update(floor_points(3000), seed);
  EXPECT_EQ(estimate.state, GroundState::kTracked);
  EXPECT_NEAR(estimate.plane.offset, 1.5F, 0.005F);
  EXPECT_GT(estimate.plane.normal.dot(Eigen::Vector3f(0.0F, -1.0F, 0.0F)), std::cos(0.005F));
}

TEST(Ground, IsTrackedWithoutSeedWhileTheCameraNods) {
  GroundTracker tracker{GroundParameters{}};
  tracker.update(floor_points(3000), level(1.5F));
  for (int i = 1; i <= 20; ++i) {
    const Eigen::AngleAxisf nod(0.005F * static_cast<float>(i), Eigen::Vector3f::UnitX());
    Points points = floor_points(3000, 1.5F, static_cast<unsigned>(i));
    for (auto& p : points) p = nod * p;
    const auto estimate = tracker.update(points, std::nullopt);
    ASSERT_EQ(estimate.state, GroundState::kTracked);
    EXPECT_GT(estimate.plane.normal.dot(nod * Eigen::Vector3f(0.0F, -1.0F, 0.0F)), std::cos(0.01F));
  }
}

TEST(Ground, StaysKnownWhenTuned) {
  GroundTracker tracker(GroundParameters{});
  tracker.update(floor_points(2000), level(1.5F));
  GroundParameters stricter;
  stricter.min_inliers = 5000;
  tracker.tune(stricter);
  const GroundEstimate held = tracker.update(floor_points(2000), std::nullopt);
  EXPECT_EQ(held.state, GroundState::kHeld);
  EXPECT_NEAR(held.plane.offset, 1.5, 0.02);
}

TEST(Ground, IsHeldWhileHiddenAndTrackedAgainAfterwards) {
  GroundTracker tracker{GroundParameters{}};
  tracker.update(floor_points(3000), std::nullopt);
  EXPECT_EQ(tracker.update(floor_points(3000), level(1.5F)).state, GroundState::kTracked);
  const auto hidden = tracker.update({}, level(1.5F));
  EXPECT_EQ(hidden.state, GroundState::kHeld);
  EXPECT_NEAR(hidden.plane.offset, 1.5F, 0.01F);
  EXPECT_EQ(tracker.update(floor_points(3000), level(1.5F)).state, GroundState::kTracked);
}

TEST(Ground, IsRecoveredFromTheSeedWhenTheTrackIsLost) {
  GroundTracker tracker{GroundParameters{}};
  tracker.update(floor_points(3000, 1.5F), level(1.5F));
  const auto estimate = tracker.update(floor_points(3000, 2.5F), level(2.5F));  // a lift went up
  EXPECT_EQ(estimate.state, GroundState::kTracked);
  EXPECT_NEAR(estimate.plane.offset, 2.5F, 0.01F);
}

TEST(Ground, IsNeverATableOrAWall) {
  GroundTracker tracker{GroundParameters{}};
  const auto table = tracker.update(floor_points(5000, 0.75F), level(1.5F));
  EXPECT_EQ(table.state, GroundState::kHeld);
  EXPECT_NEAR(table.plane.offset, 1.5F, 1e-6F);
  Points wall;
  for (const auto& p : floor_points(5000)) wall.push_back({p.x(), p.z() - 3.0F, 3.0F});
  EXPECT_EQ(tracker.update(wall, level(1.5F)).state, GroundState::kHeld);
}

TEST(Ground, IsUnknownWithoutSeed) {
  GroundTracker tracker{GroundParameters{}};
  EXPECT_EQ(tracker.update(floor_points(3000), std::nullopt).state, GroundState::kUnknown);
}

TEST(Ground, IsTheLowestLargePlaneWhenSearchedFor) {
  Points scene = floor_points(1500, 1.5F);
  for (const auto& p : floor_points(4000, 0.75F, 2)) scene.push_back(p);  // a large table
  for (const auto& p : floor_points(4000, -1.2F, 3)) scene.push_back(p);  // the ceiling
  const auto plane = find_ground(scene, {0.0F, -1.0F, 0.0F}, 0.5);
  ASSERT_TRUE(plane);
  EXPECT_NEAR(plane->offset, 1.5F, 0.02F);
  EXPECT_FALSE(find_ground({}, {0.0F, -1.0F, 0.0F}, 0.5));
}

TEST(GroundFrame, TurnsHeightIntoZ) {
  const GroundPlane plane{Eigen::Vector3f(0.05F, -0.97F, -0.2F).normalized(), 1.3F};
  const GroundFrame frame(plane);
  const Eigen::Vector3f p(0.4F, 0.7F, 3.0F);
  EXPECT_NEAR(frame.to_ground(p).z(), plane.height(p), 1e-5F);
  EXPECT_TRUE(frame.to_camera(frame.to_ground(p)).isApprox(p, 1e-5F));
  EXPECT_NEAR(frame.R.determinant(), 1.0F, 1e-5F);
  EXPECT_GT(frame.to_ground({0.0F, 0.0F, 2.0F}).x(), 1.5F);  // x: where the camera looks
}

std::set<std::set<int>> brute_force_clusters(const Points& points, float tolerance) {
  std::vector<int> label(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) label[i] = static_cast<int>(i);
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t i = 0; i < points.size(); ++i)
      for (std::size_t j = 0; j < points.size(); ++j)
        if ((points[i] - points[j]).norm() <= tolerance && label[j] < label[i]) {
          label[i] = label[j];
          changed = true;
        }
  }
  std::map<int, std::set<int>> sets;
  for (std::size_t i = 0; i < points.size(); ++i) sets[label[i]].insert(static_cast<int>(i));
  std::set<std::set<int>> result;
  for (const auto& entry : sets) result.insert(entry.second);
  return result;
}

TEST(Clusters, AreThoseOfBruteForce) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> place(-0.6F, 0.6F);
    Points points;
    for (int i = 0; i < 150; ++i) points.push_back({place(random), place(random), place(random)});
    ClusterParameters parameters;
    parameters.min_points = 1;
    std::set<std::set<int>> ours;
    for (const auto& cluster : euclidean_clusters(points, parameters))
      ours.insert(std::set<int>(cluster.begin(), cluster.end()));
    EXPECT_EQ(ours, brute_force_clusters(points, 0.12F)) << "seed " << seed;
  }
}

TEST(Clusters, OfNothingAreNone) {
  EXPECT_TRUE(euclidean_clusters({}, {}).empty());
  EXPECT_TRUE(head_subclusters({}, {}, {}).empty());
}

std::vector<Candidate> candidates_of(const Points& points) {
  return head_subclusters(points, euclidean_clusters(points, {}), {});
}

TEST(Heads, OnePersonIsOneCandidateWithItsHeight) {
  Points points;
  add_person(points, 3.0F, 0.5F);
  const auto candidates = candidates_of(points);
  ASSERT_EQ(candidates.size(), 1U);
  EXPECT_NEAR(candidates[0].head.z(), 1.75F, 0.01F);
  EXPECT_NEAR(candidates[0].head.x(), 3.0F, 0.1F);
  EXPECT_EQ(candidates[0].points.size(), points.size());
  EXPECT_GT(candidates[0].headness, 0.9F);
}

TEST(Heads, TwoPersonsShoulderToShoulderAreTwoCandidates) {
  Points points;
  add_person(points, 3.0F, 0.0F);
  add_person(points, 3.0F, 0.45F);
  ASSERT_EQ(euclidean_clusters(points, {}).size(), 1U);
  EXPECT_EQ(candidates_of(points).size(), 2U);
}

TEST(Heads, AWallIsLessLikeAHeadThanAPerson) {
  Points points;
  add_person(points, 2.0F, 0.0F);
  for (float y = -2.0F; y < 2.0F; y += 0.06F)
    for (float z = 0.12F; z < 2.0F; z += 0.06F) points.push_back({4.0F, y, z});
  const auto candidates = candidates_of(points);
  ASSERT_GT(candidates.size(), 1U);
  EXPECT_NEAR(candidates[0].head.x(), 2.0F, 0.15F);
  EXPECT_LT(candidates[1].headness, candidates[0].headness);
}

TEST(Heads, TooLowTooHighTooFlatAreNone) {
  Points points;
  add_cylinder(points, 2.0F, 0.0F, 0.2F, 0.12F, 1.1F);   // a bin
  add_cylinder(points, 3.0F, 1.5F, 0.2F, 0.12F, 2.28F);  // a post
  add_cylinder(points, 3.0F, -1.5F, 0.3F, 1.4F, 1.7F);   // a lamp
  EXPECT_TRUE(candidates_of(points).empty());
}

TEST(Roi, SpansFromHeadToFeet) {
  Points points;
  add_person(points, 3.0F, 0.0F);
  auto candidates = candidates_of(points);
  ASSERT_EQ(candidates.size(), 1U);
  project_rois(candidates, points, level(1.2F), {500.0, 500.0, 320.0, 240.0});
  const cv::Rect& roi = candidates[0].roi;
  EXPECT_NEAR(roi.y, 240.0 - 500.0 * 0.55 / 3.0, 4.0);
  EXPECT_NEAR(roi.br().y, 240.0 + 500.0 * 1.2 / 3.0, 4.0);
  EXPECT_NEAR(roi.x + 0.5 * roi.width, 320.0, 3.0);
}

TEST(Matching, GivesEachBoxToTheRoiItFitsBest) {
  const std::vector<cv::Rect2f> rois = {{0, 0, 10, 20}, {2, 0, 10, 20}, {100, 0, 10, 20}};
  const auto [scores, unmatched] =
      match_boxes(rois, {{{2, 0, 10, 20}, 0.8F}, {{300, 0, 10, 20}, 0.9F}});
  EXPECT_EQ(scores, (std::vector<float>{0.0F, 0.8F, 0.0F}));
  ASSERT_EQ(unmatched.size(), 1U);
  EXPECT_FLOAT_EQ(unmatched[0].probability, 0.9F);
}

const Intrinsics kCamera{500.0, 500.0, 320.0, 240.0};

// The picture of a person of 1.75 m at (x, 0), seen from 1.2 m.
Box box_of_person(float x) {
  const float top = 240.0F - 500.0F * 0.55F / x, feet = 240.0F + 500.0F * 1.2F / x;
  const float half = 500.0F * 0.25F / x;
  return {{320.0F - half, top, 2.0F * half, feet - top}, 0.9F};
}

void add_wall(Points& points, float x) {
  for (float y = -1.5F; y <= 1.5F; y += 0.06F)
    for (float z = 0.12F; z <= 2.28F; z += 0.06F) points.push_back({x, y, z});
}

std::optional<Candidate> in_box(const Box& box, const Points& points) {
  return candidate_in_box(box, points, level(1.2F), kCamera, HeadParameters{});
}

TEST(BoxCandidate, IsTheBodyBeforeAWallThatItTouches) {
  Points points;
  add_person(points, 3.0F, 0.0F);
  add_wall(points, 3.2F);
  EXPECT_TRUE(candidates_of(points).empty());  // the wall is higher than the head beside it
  const auto candidate = in_box(box_of_person(3.0F), points);
  ASSERT_TRUE(candidate);
  EXPECT_NEAR(candidate->head.x(), 3.0F, 0.2F);
  EXPECT_NEAR(candidate->head.y(), 0.0F, 0.1F);
  EXPECT_NEAR(candidate->head.z(), 1.75F, 0.1F);
}

TEST(BoxCandidate, IsTheBodyBehindAnUpright) {
  Points points;
  add_person(points, 4.0F, 0.0F);
  add_cylinder(points, 2.5F, 0.05F, 0.05F, 0.12F, 2.28F);
  const auto candidate = in_box(box_of_person(4.0F), points);
  ASSERT_TRUE(candidate);
  EXPECT_NEAR(candidate->head.x(), 4.0F, 0.25F);
}

TEST(BoxCandidate, IsNoneWithoutABodyInTheBox) {
  EXPECT_FALSE(in_box(box_of_person(3.0F), {}));
  Points low;  // a carton, and a person in a picture on it
  add_cylinder(low, 3.0F, 0.0F, 0.3F, 0.12F, 0.7F);
  EXPECT_FALSE(in_box(box_of_person(3.0F), low));
  Points behind;
  add_person(behind, -3.0F, 0.0F);
  EXPECT_FALSE(in_box(box_of_person(3.0F), behind));
}

constexpr double kFloor = 0.1;
const OutputLayout kLayout{{64, 32}, 0, kFloor};

void expect_box(const Box& box, cv::Rect2f rect, float probability) {
  EXPECT_NEAR(box.rect.x, rect.x, 1e-3F);
  EXPECT_NEAR(box.rect.y, rect.y, 1e-3F);
  EXPECT_NEAR(box.rect.width, rect.width, 1e-3F);
  EXPECT_NEAR(box.rect.height, rect.height, 1e-3F);
  EXPECT_NEAR(box.probability, probability, 1e-4F);
}

TEST(Decoders, Darknet) {
  const cv::Mat rows = (cv::Mat_<float>(2, 7) << 0.5F, 0.5F, 0.25F, 0.5F, 0.9F, 0.8F, 0.0F,  //
                        0.5F, 0.5F, 0.25F, 0.5F, 0.9F, 0.01F, 0.8F);
  const auto boxes = decode_darknet({rows}, kLayout);
  ASSERT_EQ(boxes.size(), 1U);
  expect_box(boxes[0], {24, 8, 16, 16}, 0.8F);
  EXPECT_THROW(decode_darknet({cv::Mat::zeros(2, 5, CV_32F)}, kLayout), std::runtime_error);
}

TEST(Decoders, Yolov5) {
  const int sizes[] = {1, 2, 7};
  cv::Mat output(3, sizes, CV_32F, cv::Scalar(0));
  const std::vector<float> row = {32, 16, 16, 16, 0.5F, 0.8F, 0.0F};
  std::copy(row.begin(), row.end(), output.ptr<float>(0, 1));
  const auto boxes = decode_yolov5({output}, kLayout);
  ASSERT_EQ(boxes.size(), 1U);
  expect_box(boxes[0], {24, 8, 16, 16}, 0.4F);
}

TEST(Decoders, Yolov8) {
  const int sizes[] = {1, 6, 3};
  cv::Mat output(3, sizes, CV_32F, cv::Scalar(0));
  const std::vector<float> column = {32, 16, 16, 16, 0.7F, 0.0F};
  for (int i = 0; i < 6; ++i) output.ptr<float>(0, i)[2] = column[i];
  const auto boxes = decode_yolov8({output}, kLayout);
  ASSERT_EQ(boxes.size(), 1U);
  expect_box(boxes[0], {24, 8, 16, 16}, 0.7F);
}

TEST(Decoders, Yolov8CutAtItsHeads) {
  const int sizes[] = {1, 66, 1, 2};  // stride 32
  cv::Mat output(4, sizes, CV_32F, cv::Scalar(-20));
  auto* values = output.ptr<float>();
  const int cell = 1, cells = 2;
  for (int side = 0; side < 4; ++side)
    for (int bin = 0; bin < 16; ++bin)
      values[(side * 16 + bin) * cells + cell] = bin == 1 ? 20.0F : -20.0F;  // distance: 1 cell
  values[64 * cells + cell] = 0.0F;                                          // probability 0.5
  const auto boxes = decode_yolov8_heads({output}, kLayout);
  ASSERT_EQ(boxes.size(), 1U);
  expect_box(boxes[0], {16, -16, 64, 64}, 0.5F);
}

TEST(Decoders, NanoDet) {
  std::vector<cv::Mat> outputs;
  for (const int stride : {8, 16, 32}) {
    const int cells = 64 / stride * (32 / stride);
    const int class_sizes[] = {1, cells, 2}, distance_sizes[] = {1, cells, 32};
    outputs.emplace_back(3, class_sizes, CV_32F, cv::Scalar(0));
    outputs.emplace_back(3, distance_sizes, CV_32F, cv::Scalar(-20));
  }
  outputs[4].ptr<float>(0, 1)[0] = 0.6F;
  for (int side = 0; side < 4; ++side) outputs[5].ptr<float>(0, 1)[side * 8 + 1] = 20.0F;
  const auto boxes = decode_nanodet(outputs, kLayout);
  ASSERT_EQ(boxes.size(), 1U);
  expect_box(boxes[0], {16, -16, 64, 64}, 0.6F);
  EXPECT_THROW(decode_nanodet({outputs[0]}, kLayout), std::runtime_error);
}

std::string error_of(const YoloParameters& parameters) {
  try {
    YoloConfidence confidence(parameters);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

TEST(Yolo, WithoutAUsableModelNamesTheParameter) {
  EXPECT_NE(error_of({}).find("yolo/model is not set"), std::string::npos);
  YoloParameters missing;
  missing.model = "/nowhere/model.onnx";
  EXPECT_NE(error_of(missing).find("/nowhere/model.onnx"), std::string::npos);
  YoloParameters broken;
  broken.model = __FILE__;
  EXPECT_NE(error_of(broken).find("yolo/model"), std::string::npos);
}

TEST(FrameIo, DepthAndPinholeAgree) {
  const Intrinsics camera{500.0, 510.0, 319.0, 241.0};
  cv::Mat depth(480, 640, CV_16UC1, cv::Scalar(2000));
  depth.at<std::uint16_t>(0, 0) = 0;
  const RgbdFrame frame = from_depth(depth, cv::Mat(480, 640, CV_8UC3), camera);
  EXPECT_TRUE(std::isnan(frame.xyz.at<cv::Vec3f>(0, 0)[2]));
  EXPECT_NEAR(frame.xyz.at<cv::Vec3f>(341, 419)[0], 0.4F, 1e-5F);
  EXPECT_NEAR(frame.xyz.at<cv::Vec3f>(343, 419)[1], 0.4F, 1e-5F);
  const Intrinsics estimate = estimate_intrinsics(frame.xyz);
  EXPECT_NEAR(estimate.fx, 500.0, 0.01);
  EXPECT_NEAR(estimate.cy, 241.0, 0.01);
  EXPECT_THROW(estimate_intrinsics(cv::Mat(480, 640, CV_32FC3, cv::Scalar::all(kNan))),
               std::runtime_error);
  EXPECT_THROW(from_depth(cv::Mat(4, 4, CV_8UC1), {}, camera), std::runtime_error);
  for (const Intrinsics& none : {Intrinsics{0.0, 510.0, 319.0, 241.0},
                                 {kNan, 510.0, 319.0, 241.0},
                                 {500.0, 510.0, kNan, 241.0}})
    EXPECT_THROW(from_depth(depth, {}, none), std::runtime_error);
  EXPECT_THROW(load_pcd("/nowhere.pcd"), std::runtime_error);
}

TEST(Detector, SurvivesFramesThatShowNothing) {
  PersonDetector detector{DetectorParameters{}};
  RgbdFrame frame{cv::Mat(480, 640, CV_32FC3, cv::Scalar::all(kNan)),
                  cv::Mat(480, 640, CV_8UC3, cv::Scalar::all(0)),
                  {525.0, 525.0, 319.5, 239.5}};
  const auto result = detector.detect(frame, level(1.5F));
  EXPECT_EQ(result.voxels, 0);
  EXPECT_TRUE(result.detections.empty());
  frame.xyz.setTo(cv::Scalar::all(kInf));
  EXPECT_TRUE(detector.detect(frame, std::nullopt).detections.empty());
}

}  // namespace
}  // namespace safe_passage::person_detection

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
