"""One registration of two clouds, by small_gicp."""

from __future__ import annotations

import numpy as np
import small_gicp


class Cloud:
    """Points thinned to a voxel grid, with covariances and a search tree.

    Args:
        points: (N, 3) [m].
        voxel: [m] edge.
        neighbours: from which a point's covariance comes.
    """

    def __init__(self, points: np.ndarray, voxel: float, neighbours: int) -> None:
        self.cloud, self.tree = small_gicp.preprocess_points(
            np.ascontiguousarray(points, float), voxel, neighbours, 1
        )

    def __len__(self) -> int:
        return int(self.cloud.size())


def register(
    source: Cloud, target: Cloud, method: str, distance: float, iterations: int
) -> np.ndarray:
    """T_target_source (4, 4) that lays `source` on `target`, from where they are.

    Args:
        method: GICP [Segal 2009], ICP or PLANE_ICP.
        distance: [m] of partners, at most.
    """
    result = small_gicp.align(
        target.cloud,
        source.cloud,
        target.tree,
        np.eye(4),
        registration_type=method,
        max_correspondence_distance=distance,
        num_threads=1,
        max_iterations=iterations,
        rotation_epsilon=1e-4,
        translation_epsilon=1e-4,
    )
    return np.asarray(result.T_target_source)
