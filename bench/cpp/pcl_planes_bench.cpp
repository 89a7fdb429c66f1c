// PCL's RANSAC multi-plane segmentation on one cloud, for the side-by-side run, as its tutorial
// does it: pcl_planes_bench CLOUD.pcd RUNS TOLERANCE MIN_POINTS
// Prints the times of all runs [ms] in a line, then a line a plane: normal, offset, points.
#include <pcl/ModelCoefficients.h>
#include <pcl/filters/extract_indices.h>
#include <pcl/io/pcd_io.h>
#include <pcl/point_types.h>
#include <pcl/segmentation/sac_segmentation.h>

#include <chrono>
#include <cstdlib>
#include <iostream>
#include <vector>

namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

struct Plane {
  pcl::ModelCoefficients equation;
  std::size_t points;
};

std::vector<Plane> extract(Cloud::Ptr cloud, double tolerance, std::size_t least) {
  pcl::SACSegmentation<pcl::PointXYZ> segmentation;
  segmentation.setOptimizeCoefficients(true);
  segmentation.setModelType(pcl::SACMODEL_PLANE);
  segmentation.setMethodType(pcl::SAC_RANSAC);
  segmentation.setMaxIterations(1000);
  segmentation.setDistanceThreshold(tolerance);
  pcl::ExtractIndices<pcl::PointXYZ> rest;
  std::vector<Plane> found;
  while (cloud->size() >= least) {
    pcl::PointIndices::Ptr inliers(new pcl::PointIndices);
    pcl::ModelCoefficients equation;
    segmentation.setInputCloud(cloud);
    segmentation.segment(*inliers, equation);
    if (inliers->indices.size() < least) break;
    found.push_back({equation, inliers->indices.size()});
    rest.setInputCloud(cloud);
    rest.setIndices(inliers);
    rest.setNegative(true);
    Cloud::Ptr left(new Cloud);
    rest.filter(*left);
    cloud = left;
  }
  return found;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 5) {
    std::cerr << "usage: pcl_planes_bench CLOUD.pcd RUNS TOLERANCE MIN_POINTS\n";
    return 2;
  }
  Cloud::Ptr cloud(new Cloud);
  if (pcl::io::loadPCDFile(argv[1], *cloud) != 0) return 1;
  std::vector<Plane> planes;
  for (int run = 0; run < std::atoi(argv[2]); ++run) {
    const auto start = std::chrono::steady_clock::now();
    planes = extract(cloud, std::atof(argv[3]), static_cast<std::size_t>(std::atol(argv[4])));
    const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
    std::cout << took.count() << ' ';
  }
  std::cout << '\n';
  for (const Plane& plane : planes) {
    for (float value : plane.equation.values) std::cout << value << ' ';
    std::cout << plane.points << '\n';
  }
  return 0;
}
