// Euclidean clusters, and in each the sub-clusters under the peaks of its height map (paper 002,
// section 2.2, after Munaro et al.).
#pragma once

#include "safe_passage/person_detection/types.h"

namespace safe_passage::person_detection {

struct ClusterParameters {
  double tolerance = 0.12;         // [m] points nearer than this belong together
  int min_points = 30;             // voxels
  double min_above_ground = 0.10;  // [m] lower points are ground
  double max_above_ground = 2.30;  // [m] higher points are racks, lamps, ceiling
};

struct HeadParameters {
  double min_height = 1.30;     // [m] of a person
  double max_height = 2.10;     // [m]
  double head_distance = 0.30;  // [m] between two heads: the higher one wins
  double body_radius = 0.45;    // [m] points this near to a head's vertical are its body
  double min_extent = 0.50;     // [m] visible part, top to bottom
  int min_points = 30;          // voxels
  int max_candidates = 20;      // those most like a head are kept
};

// Points between the ground and max_above_ground, in the ground frame.
Points above_ground(const Points& voxels, const GroundPlane& ground,
                    const ClusterParameters& parameters);

// Connected components under the tolerance, exactly; smaller ones than min_points are left out.
std::vector<Indices> euclidean_clusters(const Points& points, const ClusterParameters& parameters);

// Candidates of all clusters, the most head-like first. The image ROI is not filled in.
std::vector<Candidate> head_subclusters(const Points& points, const std::vector<Indices>& clusters,
                                        const HeadParameters& parameters);

}  // namespace safe_passage::person_detection
