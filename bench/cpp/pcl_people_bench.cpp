// PCL's own people detector on one cloud, for the side-by-side run: pcl_people_bench CLOUD.pcd
// SVM.yaml RUNS Prints one line: the times of all runs [ms], then the confidences of the
// candidates.
#include <pcl/io/pcd_io.h>
#include <pcl/people/ground_based_people_detection_app.h>
#include <pcl/point_types.h>

#include <chrono>
#include <cstdlib>
#include <iostream>

int main(int argc, char** argv) {
  if (argc != 4) {
    std::cerr << "usage: pcl_people_bench CLOUD.pcd SVM.yaml RUNS\n";
    return 2;
  }
  using Point = pcl::PointXYZRGB;
  pcl::PointCloud<Point>::Ptr cloud(new pcl::PointCloud<Point>);
  pcl::people::PersonClassifier<pcl::RGB> classifier;
  if (pcl::io::loadPCDFile(argv[1], *cloud) != 0 || !classifier.loadSVMFromFile(argv[2])) return 1;
  Eigen::Matrix3f intrinsics;
  intrinsics << 525.0F, 0.0F, 319.5F, 0.0F, 525.0F, 239.5F, 0.0F, 0.0F, 1.0F;
  Eigen::VectorXf ground(4);
  ground << -0.0103586F, 0.997011F, 0.0765573F,
      -1.26614F;  // of five_people.pcd, as PCL's test has it

  std::vector<pcl::people::PersonCluster<Point>> clusters;
  std::cout << "ms";
  for (int run = 0; run < std::atoi(argv[3]); ++run) {
    pcl::people::GroundBasedPeopleDetectionApp<Point> detector;
    detector.setVoxelSize(0.06F);
    detector.setIntrinsics(intrinsics);
    detector.setClassifier(classifier);
    detector.setPersonClusterLimits(1.3F, 2.3F, 0.1F, 8.0F);
    clusters.clear();
    const auto start = std::chrono::steady_clock::now();
    detector.setInputCloud(cloud);
    detector.setGround(ground);
    detector.compute(clusters);
    const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
    std::cout << ' ' << took.count();
  }
  std::cout << " confidences";
  for (auto& cluster : clusters) std::cout << ' ' << cluster.getPersonConfidence();
  std::cout << '\n';
  return 0;
}
