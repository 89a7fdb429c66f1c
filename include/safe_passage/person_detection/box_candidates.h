// Candidates from persons that only the picture shows: before a wall, behind a rack's upright or
// among shelves a body is one cluster with what it touches, and no head stands out.
#pragma once

#include <optional>

#include "safe_passage/person_detection/clustering.h"
#include "safe_passage/person_detection/confidence.h"

namespace safe_passage::person_detection {

// The body in a box of the picture: the points in its middle that lie at the distance where most of
// them do. `points` are over the ground, ground frame. No value where too few points, or none of a
// person's height, lie there: a box without a body is no person.
std::optional<Candidate> candidate_in_box(const Box& box, const Points& points,
                                          const GroundPlane& ground, const Intrinsics& camera,
                                          const HeadParameters& parameters);

}  // namespace safe_passage::person_detection
