// Safety areas against values worked out by hand. The circle used most: 5 m away, radius 3 m, so
// that its half angle is asin(0.6) = 36.87 degrees, and on a beam 30 degrees off it begins at
// 5 cos 30 - sqrt(9 - (5 sin 30)^2) = 4.3301 - 1.6583 = 2.6718 m.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "safe_passage/safety_area/pipeline.h"

using namespace safe_passage::safety_area;

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr double kAt30 = 2.6718;  // [m] see above

double rad(double degrees) { return degrees * M_PI / 180.0; }

// Angles in degrees.
Scan make_scan(double from, double step, std::size_t beams, float range = 10.0F) {
  Scan scan;
  scan.angle_min = rad(from);
  scan.angle_increment = rad(step);
  scan.angle_max = rad(from + step * static_cast<double>(beams - 1));
  scan.range_min = 0.1;
  scan.range_max = 20.0;
  scan.ranges.assign(beams, range);
  return scan;
}

bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

void expect_ranges(const std::vector<float>& ranges, const std::vector<double>& expected) {
  ASSERT_EQ(ranges.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i)
    EXPECT_NEAR(ranges[i], expected[i], 1e-3) << "beam " << i;
}

TEST(Merge, DrawsTheNearArcOfACircleAhead) {
  const auto merged = merge(make_scan(-60, 30, 5), {{5, 0, 3}});
  expect_ranges(merged.ranges, {10, kAt30, 2, kAt30, 10});
  EXPECT_EQ(merged.safety_ranges[0], kInf);
  expect_ranges({merged.safety_ranges.begin() + 1, merged.safety_ranges.end() - 1},
                {kAt30, 2, kAt30});
  EXPECT_EQ(merged.fault, ScanFault::kNone);
}

TEST(Merge, MeasuresTheBearingFromX) {  // not the paper's arctan2(x, y)
  expect_ranges(merge(make_scan(-90, 90, 3), {{0, 5, 3}}).ranges, {10, 10, 2});
}

TEST(Merge, FillsTheHalfAngleAsinOfRadiusOverDistance) {  // not the paper's arccos: 53.13 degrees
  const auto merged = merge(make_scan(36, 1.5, 2), {{5, 0, 3}});
  EXPECT_LT(merged.ranges[0], 4.1);  // the tangent is 4 m long
  EXPECT_EQ(merged.ranges[1], 10.0F);
}

TEST(Merge, NearestOfSeveralCirclesWins) {
  const auto merged = merge(make_scan(-30, 30, 3), {{5, 0, 3}, {4, 0, 2.5}, {4, 0, 1}});
  expect_ranges(merged.ranges, {2 * std::sqrt(3) - 1.5, 1.5, 2 * std::sqrt(3) - 1.5});
}

TEST(Merge, ANearerMeasurementStays) {
  const auto scan = make_scan(-30, 30, 3, 1.9F);
  EXPECT_TRUE(same_bits(merge(scan, {{5, 0, 3}}).ranges, scan.ranges));
}

TEST(Merge, CircleTakesBeamsThatMeasuredNothing) {
  auto scan = make_scan(-6, 2, 7);
  scan.ranges = {kNan, kInf, -kInf, 0.0F, 25.0F, 0.05F, -1.0F};
  for (const float range : merge(scan, {{5, 0, 3}}).ranges) EXPECT_NEAR(range, 2.0, 0.1);
}

TEST(Merge, OtherBeamsKeepEveryBit) {
  auto scan = make_scan(90, 2, 7);
  scan.ranges = {kNan, kInf, -kInf, 0.0F, 25.0F, 0.05F, -1.0F};
  scan.intensities = {kNan, 1, 2, 3, 4, 5, 6};
  const auto merged = merge(scan, {{5, 0, 3}});
  EXPECT_TRUE(same_bits(merged.ranges, scan.ranges));
  EXPECT_TRUE(same_bits(merged.intensities, scan.intensities));
  for (const float range : merged.safety_ranges) EXPECT_EQ(range, kInf);
}

TEST(Merge, CircleAcrossPi) {
  const auto merged = merge(make_scan(-180, 30, 12), {{-5, 0, 3}});
  expect_ranges(merged.ranges, {2, kAt30, 10, 10, 10, 10, 10, 10, 10, 10, 10, kAt30});
}

TEST(Merge, FirstBeamAheadAndAllTheWayRound) {
  const auto merged = merge(make_scan(0, 30, 12), {{5, 0, 3}});
  expect_ranges(merged.ranges, {2, kAt30, 10, 10, 10, 10, 10, 10, 10, 10, 10, kAt30});
}

TEST(Merge, MoreThanATurnSeesTheCircleTwice) {
  const auto merged = merge(make_scan(-90, 90, 7), {{5, 0, 3}});
  expect_ranges(merged.ranges, {10, 2, 10, 10, 10, 2, 10});
}

TEST(Merge, AnglesMayStartTurnsAway) {
  expect_ranges(merge(make_scan(720 - 30, 30, 3), {{5, 0, 3}}).ranges, {kAt30, 2, kAt30});
}

TEST(Merge, ReversedScan) {
  expect_ranges(merge(make_scan(60, -30, 4), {{5, 0, 3}}).ranges, {10, kAt30, 2, kAt30});
}

TEST(Merge, CircleOutsideTheFieldOfView) {
  const auto scan = make_scan(-60, 30, 5);
  EXPECT_TRUE(same_bits(merge(scan, {{-5, 0, 3}}).ranges, scan.ranges));
}

TEST(Merge, CircleAtTheEdgeOfAPartialScan) {
  expect_ranges(merge(make_scan(-150, 30, 5), {{5, 0, 3}}).ranges, {10, 10, 10, 10, kAt30});
}

TEST(Merge, CircleNearerThanRangeMinIsDrawnThere) {
  auto scan = make_scan(-30, 30, 3);
  scan.range_min = 2.5;
  expect_ranges(merge(scan, {{5, 0, 3}}).ranges, {kAt30, 2.5, kAt30});
  scan.ranges[1] = 2.5F;  // never longer than what was measured
  expect_ranges(merge(scan, {{5, 0, 3}}).ranges, {kAt30, 2.5, kAt30});
}

TEST(Merge, CircleBeyondRangeMaxIsNotDrawn) {
  auto scan = make_scan(-30, 30, 3, kInf);
  scan.range_max = 2.5;
  const auto merged = merge(scan, {{5, 0, 3}});
  EXPECT_EQ(merged.ranges[0], kInf);
  EXPECT_NEAR(merged.ranges[1], 2.0, 1e-6);
}

TEST(Merge, ScansWithoutMeaningPassUnchanged) {
  const auto good = make_scan(-30, 30, 3);
  std::vector<Scan> scans(9, good);
  scans[0].angle_increment = 0.0;
  scans[1].angle_increment = std::nan("");
  scans[2].angle_min = std::nan("");
  scans[3].angle_increment = 7.0;  // more than a turn
  scans[4].range_max = std::nan("");
  scans[5].range_min = std::nan("");
  scans[6].range_max = 0.05;  // less than range_min
  scans[7].range_min = -2.0;
  scans[7].range_max = -1.0;
  scans[8].angle_min = INFINITY;
  for (const Scan& scan : scans) {
    const auto merged = merge(scan, {{5, 0, 3}});
    EXPECT_EQ(merged.fault, ScanFault::kBadGeometry);
    EXPECT_TRUE(same_bits(merged.ranges, scan.ranges));
  }
  const auto empty = merge(Scan{}, {{5, 0, 3}});
  EXPECT_EQ(empty.fault, ScanFault::kEmpty);
  EXPECT_TRUE(empty.ranges.empty());
}

TEST(Merge, WrongNumberOfBeamsIsReportedAndMerged) {
  auto scan = make_scan(-60, 30, 5);
  scan.ranges.resize(3);
  const auto merged = merge(scan, {{5, 0, 3}});
  EXPECT_EQ(merged.fault, ScanFault::kBeamCount);
  expect_ranges(merged.ranges, {10, kAt30, 2});
  scan.ranges.resize(4);  // one beam off is a common rounding of drivers
  EXPECT_EQ(merge(scan, {}).fault, ScanFault::kNone);
}

TEST(Merge, VirtualBeamsGetTheIntensity) {
  auto scan = make_scan(-30, 60, 3, 10.0F);
  scan.intensities = {7, 8, 9};
  MergeParameters params;
  params.intensity = 500.0F;
  const auto merged = merge(scan, {{5, 0, 3}}, params);
  EXPECT_EQ(merged.intensities, (std::vector<float>{500, 500, 9}));
  EXPECT_EQ(merged.safety_intensities, (std::vector<float>{500, 500, 0}));
  scan.intensities = {7};  // of another length: they belong to no beam
  EXPECT_EQ(merge(scan, {{5, 0, 3}}, params).intensities, (std::vector<float>{7}));
  scan.intensities.clear();
  EXPECT_TRUE(merge(scan, {{5, 0, 3}}, params).intensities.empty());
}

TEST(Merge, CirclesThatAreNoneAreIgnoredAndCounted) {
  const auto scan = make_scan(-60, 30, 5);
  const double nan = std::nan("");
  const auto merged = merge(
      scan, {{nan, 0, 3}, {5, INFINITY, 3}, {5, 0, nan}, {5, 0, INFINITY}, {5, 0, 0}, {5, 0, -1}});
  EXPECT_EQ(merged.ignored, 6);
  EXPECT_TRUE(same_bits(merged.ranges, scan.ranges));
}

// A person 1 m ahead with an area of 1.2 m: the laser is inside.
TEST(Inside, ShrinkKeepsTheClearanceAndTheWayBack) {
  const auto merged = merge(make_scan(-180, 90, 4), {{1, 0, 1.2}});
  expect_ranges(merged.ranges, {10, 10, 0.3, 10});
  EXPECT_EQ(merged.inside, 1);
}

TEST(Inside, ShrinkBeginsWhereTheCircleReachesTheRobot) {
  const auto ahead = make_scan(-1, 1, 3);
  EXPECT_NEAR(merge(ahead, {{1.6, 0, 1.2}}).ranges[1], 0.4, 1e-6);
  EXPECT_NEAR(merge(ahead, {{1.4, 0, 1.2}}).ranges[1], 0.3, 1e-6);
  EXPECT_EQ(merge(ahead, {{1.6, 0, 1.2}}).inside, 0);
}

TEST(Inside, ShrinkLeavesThePersonsBody) {  // 0.4 - 0.3 would leave 0.1 m of 0.2
  expect_ranges(merge(make_scan(-90, 90, 3), {{0.4, 0, 1.2}}).ranges, {10, 0.2, 10});
}

TEST(Inside, BodyLeavesThePersonAlone) {
  MergeParameters params;
  params.inside_policy = InsidePolicy::kBody;
  expect_ranges(merge(make_scan(-90, 90, 3), {{1, 0, 1.2}}, params).ranges, {10, 0.75, 10});
  EXPECT_NEAR(merge(make_scan(-1, 1, 3), {{1.3, 0, 1.2}}, params).ranges[1], 0.1, 1e-6);
}

TEST(Inside, BlockStopsTheRobot) {
  MergeParameters params;
  params.inside_policy = InsidePolicy::kBlock;
  expect_ranges(merge(make_scan(-90, 90, 3), {{1, 0, 1.2}}, params).ranges, {0.1, 0.1, 0.1});
  expect_ranges(merge(make_scan(-90, 90, 3), {{0, 0, 1.2}}, params).ranges, {0.1, 0.1, 0.1});
}

TEST(Inside, APersonAtTheLaserItselfLiesInNoDirection) {
  const auto scan = make_scan(-90, 90, 3);
  EXPECT_TRUE(same_bits(merge(scan, {{0, 0, 1.2}}).ranges, scan.ranges));
}

Person person(double stamp, double x, double y, std::uint32_t id = 0) {
  Person person;
  person.stamp = stamp;
  person.position = {x, y, 0};
  person.id = id;
  return person;
}

TEST(Memory, KeepsAPersonForTheHoldTime) {
  PersonMemory memory;
  memory.update({person(10, 1, 2)});
  memory.update({});  // the detector flickers
  EXPECT_EQ(memory.at(11.0).size(), 1U);
  EXPECT_EQ(memory.at(11.01).size(), 0U);
}

TEST(Memory, NearestDetectionReplacesTheOlderOne) {
  PersonMemory memory;
  memory.update({person(10, 1, 0), person(10, 1.4, 0)});
  memory.update({person(10.1, 1.5, 0)});
  const auto held = memory.at(10.1);
  ASSERT_EQ(held.size(), 2U);
  EXPECT_EQ(held[0].position.x(), 1.5);
  EXPECT_EQ(held[1].position.x(), 1.0);
}

TEST(Memory, DetectionOutsideTheGateIsAnother) {
  PersonMemory memory;
  memory.update({person(10, 1, 0)});
  memory.update({person(10.1, 1.6, 0)});
  EXPECT_EQ(memory.at(10.1).size(), 2U);
}

TEST(Memory, SameIdReplacesAtAnyDistance) {
  PersonMemory memory;
  memory.update({person(10, 1, 0, 7), person(10, 4, 0, 8)});
  memory.update({person(10.1, 3, 0, 7)});
  const auto held = memory.at(10.1);
  ASSERT_EQ(held.size(), 2U);
  EXPECT_EQ(held[0].position.x(), 3.0);
  EXPECT_EQ(held[1].id, 8U);
}

TEST(Memory, OtherIdNeverReplacesButOtherSourceMay) {
  PersonMemory memory;
  memory.update({person(10, 1, 0, 7)});
  memory.update({person(10.1, 1.1, 0, 8)});
  EXPECT_EQ(memory.at(10.1).size(), 2U);
  Person other = person(10.2, 1.15, 0, 7);
  other.source = "rear_camera";
  memory.update({other});
  const auto held = memory.at(10.2);
  ASSERT_EQ(held.size(), 2U);
  EXPECT_EQ(held[0].source, "rear_camera");
  EXPECT_EQ(held[1].id, 7U);  // the nearer one, 8, was replaced
}

TEST(Memory, TwoInOneArrayAreTwo) {
  PersonMemory memory;
  memory.update({person(10, 1, 0), person(10, 1.1, 0)});
  memory.update({person(10.1, 1, 0), person(10.1, 1.1, 0)});
  EXPECT_EQ(memory.at(10.1).size(), 2U);
}

TEST(Memory, OnePersonIsReplacedOnce) {
  PersonMemory memory;
  memory.update({person(10, 1, 0)});
  memory.update({person(10.1, 1, 0), person(10.1, 1.1, 0)});
  EXPECT_EQ(memory.at(10.1).size(), 2U);
}

TEST(Memory, MovesByTheVelocityAndDoubtsTooFast) {
  PersonMemory memory;
  Person walker = person(10, 1, 0);
  walker.velocity = {1, -2, 0};
  Person rocket = person(10, 9, 0);
  rocket.velocity = {30, 0, 0};
  Person unknown = person(10, 20, 0);
  unknown.velocity.setConstant(std::nan(""));
  memory.update({walker, rocket, unknown});
  const auto held = memory.at(10.5);
  ASSERT_EQ(held.size(), 3U);
  EXPECT_TRUE(held[0].position.isApprox(Eigen::Vector3d(1.5, -1, 0)));
  EXPECT_TRUE(held[1].position.isApprox(Eigen::Vector3d(10.5, 0, 0)));  // 3 m/s
  EXPECT_EQ(held[2].position.x(), 20.0);
  EXPECT_NEAR(memory.at(9.5)[0].position.x(), 0.5, 1e-12);  // a scan older than the detection
}

TEST(Memory, OlderDetectionIsOutOfOrder) {
  PersonMemory memory;
  memory.update({person(10, 1, 0)});
  EXPECT_EQ(memory.update({person(9.9, 1.2, 0)}).out_of_order, 1);
  EXPECT_EQ(memory.at(10)[0].position.x(), 1.0);
  EXPECT_EQ(memory.update({person(9.9, 5, 0)}).out_of_order, 0);  // but seen by nobody since
  EXPECT_EQ(memory.at(10).size(), 2U);
}

TEST(Memory, RefusesWhatIsNotFinite) {
  PersonMemory memory;
  EXPECT_EQ(memory.update({person(10, std::nan(""), 0), person(10, 1, 0)}).not_finite, 1);
  EXPECT_EQ(memory.size(), 1U);
}

TEST(Memory, IsBounded) {
  MemoryParameters params;
  params.max_persons = 3;
  PersonMemory memory(params);
  memory.update({person(10, 0, 0), person(10, 5, 0)});
  EXPECT_EQ(memory.update({person(10.1, 10, 0), person(10.1, 15, 0)}).forgotten, 1);
  EXPECT_EQ(memory.size(), 3U);
  memory.update({person(20, 0, 0)});
  EXPECT_EQ(memory.size(), 1U);
}

TEST(Areas, GrowWithTheAgeOfTheRobotsPose) {
  LaserPose pose;
  EXPECT_EQ(safety_areas({person(10, 2, 0)}, 10, pose, {})[0].radius, 1.2);
  pose.age = 0.1;  // 0.1 s * (1 m/s + 2 m * 1 rad/s)
  EXPECT_NEAR(safety_areas({person(10, 2, 0)}, 10, pose, {})[0].radius, 1.5, 1e-12);
  pose.age = 0.9;
  EXPECT_NEAR(safety_areas({person(10, 2, 0)}, 10, pose, {})[0].radius, 2.2, 1e-12);
}

TEST(Areas, GrowNoFurtherForPersonsBeyondAllDistances) {
  const auto area = safety_areas({person(10, 1.7e308, 1.7e308)}, 10, {}, {})[0];
  EXPECT_EQ(area.radius, 2.2);
}

TEST(Areas, GrowWithTheAgeOfTheDetection) {
  AreaParameters params;
  params.growth_speed = 0.5;
  EXPECT_NEAR(safety_areas({person(10, 2, 0)}, 10.4, {}, params)[0].radius, 1.4, 1e-12);
  EXPECT_EQ(safety_areas({person(10, 2, 0)}, 9.6, {}, params)[0].radius, 1.2);
}

// A memory that lets the laser keep persons for 10 s, hold_time 1 s.
PersonMemory laser_memory() {
  MemoryParameters params;
  params.laser_hold_time = 10.0;
  return PersonMemory(params);
}

const Eigen::Vector2d kLaser(0.0, 0.0);

// Two legs about (x, 0), as a laser at the origin meets them: 7 cm before their middle.
std::vector<Eigen::Vector2d> legs_at(double x) { return {{x - 0.07, -0.1}, {x - 0.07, 0.1}}; }

Person walker(double vx, double vy) {
  Person person;
  person.position = {4, 0, 0};
  person.velocity = {vx, vy, 0};
  return person;
}

TEST(Areas, ReachAheadOfAPersonWhoMoves) {
  AreaParameters params;
  params.velocity_stretch = 0.5;
  const auto areas = safety_areas({walker(0, 2)}, 0.0, LaserPose{}, params);
  ASSERT_GE(areas.size(), 3U);
  EXPECT_TRUE(areas.front().body);
  EXPECT_DOUBLE_EQ(areas.front().y, 0.0);
  EXPECT_DOUBLE_EQ(areas.back().y, 1.0);
  for (std::size_t i = 1; i < areas.size(); ++i) {
    EXPECT_FALSE(areas[i].body);
    EXPECT_DOUBLE_EQ(areas[i].x, 4.0);
    EXPECT_DOUBLE_EQ(areas[i].radius, 1.2);
    EXPECT_LE(areas[i].y - areas[i - 1].y, 0.4 * 1.2 + 1e-9);  // no gap between them
  }
}

TEST(Areas, AreCirclesByDefaultAndForThoseWhoStandOrAreOfUnknownMotion) {
  EXPECT_EQ(safety_areas({walker(0, 2)}, 0.0, LaserPose{}, {}).size(), 1U);
  AreaParameters params;
  params.velocity_stretch = 0.5;
  EXPECT_EQ(safety_areas({walker(0, 0)}, 0.0, LaserPose{}, params).size(), 1U);
  EXPECT_EQ(safety_areas({walker(kNan, 0)}, 0.0, LaserPose{}, params).size(), 1U);
}

TEST(Areas, ReachAheadInTheLasersFrame) {  // which is turned by 90 degrees to the left
  AreaParameters params;
  params.velocity_stretch = 1.0;
  LaserPose pose;
  pose.T_laser_fixed.rotate(Eigen::AngleAxisd(-M_PI / 2, Eigen::Vector3d::UnitZ()));
  const auto areas = safety_areas({walker(0, 1)}, 0.0, pose, params);
  EXPECT_NEAR(areas.back().x, 1.0, 1e-9);
  EXPECT_NEAR(areas.back().y, -4.0, 1e-9);
}

TEST(Inside, OfAPlaceWhereAPersonMayComeNothingIsLeftOnTheRobot) {
  MergeParameters params;
  const Circle ahead{0.1, 0.0, 1.2, false};
  const Scan scan = make_scan(-180, 10, 37);
  EXPECT_TRUE(same_bits(merge(scan, {ahead}, params).ranges, scan.ranges));
  params.inside_policy = InsidePolicy::kBody;
  EXPECT_TRUE(same_bits(merge(scan, {ahead}, params).ranges, scan.ranges));
  params.inside_policy = InsidePolicy::kBlock;
  EXPECT_FLOAT_EQ(merge(scan, {ahead}, params).ranges[0], 0.1F);
}

TEST(Inside, APlaceWhereAPersonMayComeIsCutBackToTheClearance) {
  const auto merged = merge(make_scan(0, 1, 1), {{1.0, 0.0, 1.2, false}});
  EXPECT_NEAR(merged.ranges[0], 0.3, 1e-6);
}

TEST(Memory, ATrackAndTheCamerasDetectionOfTheSamePersonAreOne) {
  PersonMemory memory;
  Person track = walker(2, 0);
  track.source = "odom";
  track.id = 7;
  track.stamp = 10.0;
  memory.update({track});
  Person detection;
  detection.source = "camera";
  detection.stamp = 9.7;
  detection.position = {3.4, 0, 0};  // where the person was then
  detection.velocity = {kNan, kNan, kNan};
  EXPECT_EQ(memory.update({detection}).out_of_order, 0);
  ASSERT_EQ(memory.at(10.0).size(), 1U);
  EXPECT_NEAR(memory.at(10.1).front().position.x(), 4.2, 1e-9);  // the track's, with its velocity
}

TEST(Memory, ATrackTakesOverThePersonThatTheCameraLastSaw) {
  PersonMemory memory;
  Person detection;
  detection.source = "camera";
  detection.stamp = 9.7;
  detection.position = {3.6, 0, 0};
  memory.update({detection});
  Person track = walker(1, 0);
  track.source = "odom";
  track.id = 7;
  track.stamp = 10.0;
  memory.update({track});
  ASSERT_EQ(memory.at(10.0).size(), 1U);
  EXPECT_NEAR(memory.at(10.0).front().position.x(), 4.0, 1e-9);
}

TEST(Laser, KeepsWhomTheCameraNoLongerSees) {
  auto memory = laser_memory();
  memory.update({person(0.0, 3, 0)});
  for (double time = 0.5; time < 9.9; time += 0.5) memory.follow(legs_at(3.0), kLaser, time);
  ASSERT_EQ(memory.at(10.0).size(), 1U);
  EXPECT_NEAR(memory.at(10.0)[0].position.x(), 3.0, 0.02);
}

TEST(Laser, IsNotDrawnAwayByWhatStandsBehindThePerson) {
  auto memory = laser_memory();
  memory.update({person(0.0, 3, 0)});
  auto hits = legs_at(3.0);
  for (double y = -0.3; y <= 0.3; y += 0.02) hits.emplace_back(3.3, y);  // a rack
  for (double time = 0.5; time < 5.0; time += 0.5) memory.follow(hits, kLaser, time);
  EXPECT_NEAR(memory.at(5.0)[0].position.x(), 3.0, 1e-9);
}

TEST(Laser, KeepsNobodyForLongerThanItMay) {
  auto memory = laser_memory();
  memory.update({person(0.0, 3, 0)});
  for (double time = 0.5; time < 20.0; time += 0.5) memory.follow(legs_at(3.0), kLaser, time);
  EXPECT_TRUE(memory.at(11.5).empty());
}

TEST(Laser, FollowsWhoWalksOnAndDetectionsThatComeLateStillCount) {
  auto memory = laser_memory();
  memory.update({person(0.0, 3, 0)});
  for (int i = 1; i <= 40; ++i) memory.follow(legs_at(3.0 + 0.03 * i), kLaser, 0.025 * i);
  EXPECT_NEAR(memory.at(1.0)[0].position.x(), 4.2, 0.2);
  EXPECT_EQ(memory.update({person(0.9, 4.1, 0)}).out_of_order, 0);
  ASSERT_EQ(memory.at(1.0).size(), 1U);
  EXPECT_NEAR(memory.at(1.0)[0].position.x(), 4.1, 1e-9);
}

TEST(Laser, LetsGoOfWhoHasLeft) {
  auto memory = laser_memory();
  memory.update({person(0.0, 3, 0)});
  for (double time = 0.5; time < 3.0; time += 0.5) memory.follow(legs_at(6.0), kLaser, time);
  EXPECT_TRUE(memory.at(1.5).empty());
}

TEST(Laser, NeitherBringsBackNorIsBelievedToBeFasterThanAPerson) {
  auto memory = laser_memory();
  memory.update({person(0.0, 3, 0)});
  memory.follow(legs_at(3.3), kLaser, 0.01);  // 0.3 m in 10 ms: 3 m/s at most
  ASSERT_EQ(memory.at(0.01).size(), 1U);
  EXPECT_NEAR(memory.at(0.01)[0].position.x(), 3.03, 1e-6);
  memory.follow(legs_at(3.0), kLaser, 5.0);  // held no more since 1.01 s
  EXPECT_TRUE(memory.at(5.0).empty());
}

TEST(Laser, KeepsNobodyByDefault) {
  PersonMemory memory;
  memory.update({person(0.0, 3, 0)});
  memory.follow(legs_at(3.0), kLaser, 0.9);
  EXPECT_TRUE(memory.at(1.5).empty());
}

TEST(Pipeline, LetsTheScanKeepAPersonButNotThroughAnOldPose) {
  for (const double age : {0.0, 0.2}) {
    PipelineParameters params;
    params.memory.laser_hold_time = 10.0;
    Pipeline pipeline(params);
    pipeline.remember({person(0.0, 5, 0)});
    LaserPose pose;
    pose.age = age;
    Scan scan = make_scan(-10, 1, 21, 15.0F);
    scan.ranges[9] = scan.ranges[10] = scan.ranges[11] = 4.93F;  // the legs
    for (double time = 0.5; time < 2.1; time += 0.5) pipeline.merge(scan, time, pose);
    EXPECT_EQ(pipeline.merge(scan, 2.5, pose).persons.size(), age == 0.0 ? 1U : 0U);
  }
}

TEST(Pipeline, SeesThePersonFromWhereTheLaserIs) {
  Pipeline pipeline;
  pipeline.remember({person(10, 3, 4)});
  LaserPose pose;  // the laser stands at (3, 0) and looks along y
  pose.T_laser_fixed =
      Eigen::AngleAxisd(rad(-90), Eigen::Vector3d::UnitZ()) * Eigen::Translation3d(-3, 0, 0);
  const auto result = pipeline.merge(make_scan(-90, 90, 3), 10, pose);
  expect_ranges(result.scan.ranges, {10, 2.8, 10});
  ASSERT_EQ(result.areas.size(), 1U);
  EXPECT_NEAR(result.areas[0].x, 4.0, 1e-12);
}

TEST(Pipeline, WithoutAPoseTheScanComesBack) {
  Pipeline pipeline;
  pipeline.remember({person(10, 3, 0)});
  const auto scan = make_scan(-90, 90, 3);
  EXPECT_TRUE(same_bits(pipeline.merge(scan, 10, std::nullopt).scan.ranges, scan.ranges));
}

TEST(Pipeline, TunedKeepsItsPersons) {
  Pipeline pipeline;
  pipeline.remember({Person{"", 0, 0.0, 0.0, {5.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, 1.8}});
  const Scan scan = make_scan(0.0, 1.0, 1);
  EXPECT_NEAR(pipeline.merge(scan, 0.1, LaserPose{}).scan.ranges[0], 3.8, 1e-5);
  PipelineParameters params;
  params.area.radius = 2.0;
  pipeline.tune(params);
  EXPECT_NEAR(pipeline.merge(scan, 0.2, LaserPose{}).scan.ranges[0], 3.0, 1e-5);
  params.memory.hold_time = 0.25;
  pipeline.tune(params);
  EXPECT_TRUE(pipeline.merge(scan, 0.3, LaserPose{}).areas.empty());
}

TEST(Pipeline, ClearForgets) {
  Pipeline pipeline;
  pipeline.remember({person(10, 3, 0)});
  pipeline.clear();
  EXPECT_TRUE(pipeline.merge(make_scan(-90, 90, 3), 10, LaserPose{}).persons.empty());
}

}  // namespace

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
