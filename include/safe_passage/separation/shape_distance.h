// How far the robot is from obstacles' shapes, for very many pairs (paper 000, section 5).
#pragma once

#include <Eigen/Core>
#include <vector>

namespace safe_passage::separation {

struct Disc {
  Eigen::Vector2d centre;  // [m]
  double radius;           // [m]
};

struct Capsule {
  Eigen::Vector2d start, end;  // [m]
  double radius;               // [m]
};

// The platform, a polygon of three corners and more or a single corner, with padding around it, and
// capsules beside it, such as an arm's. Frame: the robot's.
class RobotShape {
 public:
  RobotShape(std::vector<Eigen::Vector2d> corners, double padding, std::vector<Capsule> parts);

  // [m] to a point; inside negative, as deep as it is.
  double distance(const Eigen::Vector2d& point) const;

 private:
  struct Edge {
    Eigen::Vector2d start, along;
    double end_y;            // exactly, so that neighbours agree about a ray through their corner
    double inverse_squared;  // of its length, 0 of a point
  };
  static Edge edge(const Eigen::Vector2d& start, const Eigen::Vector2d& end);
  static double squared(const Edge& edge, const Eigen::Vector2d& point);

  std::vector<Edge> platform_, limbs_;
  std::vector<double> radii_;
  double padding_;
};

}  // namespace safe_passage::separation
