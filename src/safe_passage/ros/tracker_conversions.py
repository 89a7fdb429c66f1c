"""What the tracker knows, as messages."""

from __future__ import annotations

import cv2
import numpy as np
from geometry_msgs.msg import Point, Point32, Polygon, Vector3
from nav_msgs.msg import OccupancyGrid
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import Header

from safe_passage.monitoring.fusion_grid import FusionGrid
from safe_passage.monitoring.parameters import TrackerParameters
from safe_passage.monitoring.persons import Persons
from safe_passage.monitoring.pipeline import Snapshot
from safe_passage.msg import TrackedObstacle, TrackedObstacleArray

OBSTACLE, UNKNOWN = 100, -1  # of an OccupancyGrid
SQUARE = 0.5 * np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])  # corners of a cell of side 1
CELL_FIELDS = ("x", "y", "z", "min_height", "density", "points", "id", "moving")


def to_tracks(
    snapshot: Snapshot, persons: Persons, header: Header, p: TrackerParameters
) -> TrackedObstacleArray:
    """The confirmed tracks; the header's frame is base."""
    array = TrackedObstacleArray(header=header, resolution=p.resolution)
    array.sensors = [source.name for source in p.sources]
    array.alive = [name in snapshot.sources for name in array.sensors]
    tracks = snapshot.tracks
    columns = zip(
        np.flatnonzero(snapshot.confirmed).tolist(),
        *(
            column[snapshot.confirmed].tolist()
            for column in (
                tracks.id, snapshot.stamp - tracks.born, tracks.misses == 0, tracks.moving,
                tracks.position, tracks.velocity, tracks.body_covariance.reshape(-1, 16),
                tracks.height, tracks.counts, persons.labelled, persons.probability,
            )
        ),
    )  # fmt: skip
    for i, number, age, observed, moving, at, velocity, covariance, height, counts, *who in columns:
        cells = snapshot.shapes[i]
        array.obstacles.append(
            TrackedObstacle(
                id=number,
                age=age,
                observed=observed,
                moving=moving,
                classification=TrackedObstacle.PERSON if who[0] else TrackedObstacle.UNKNOWN,
                person_probability=who[1],
                position=Point(*at, 0.0),
                velocity=Vector3(*velocity, 0.0),
                covariance=covariance,
                min_height=height[0],
                max_height=height[1],
                points=counts,
                footprint=Polygon([Point32(x, y, 0.0) for x, y in hull(cells, p.resolution)]),
                cells_x=cells[:, 0].tolist(),
                cells_y=cells[:, 1].tolist(),
            )
        )
    return array


def hull(cells: np.ndarray, resolution: float) -> list[list[float]]:
    """Corners [m] of the convex outline of square `cells` (N, 2), counter-clockwise."""
    if not len(cells):
        return []
    corners = (cells[:, None] + resolution * SQUARE).reshape(-1, 2)
    return cv2.convexHull(corners.astype(np.float32), clockwise=False)[:, 0].tolist()


def to_occupancy(grid: FusionGrid, header: Header) -> OccupancyGrid:
    """Obstacle cells; what is none may be free or not seen at all, so it is unknown."""
    message = OccupancyGrid(header=header)
    message.info.map_load_time = header.stamp
    message.info.resolution = grid.resolution
    message.info.width = message.info.height = grid.side
    corner = -0.5 * grid.side * grid.resolution
    message.info.origin.position = Point(corner, corner, 0.0)
    message.info.origin.orientation.w = 1.0
    cells = np.full(grid.side**2, UNKNOWN, np.int8)
    cells[grid.cell] = OBSTACLE
    message.data = cells.tolist()
    return message


def to_cells(snapshot: Snapshot, header: Header) -> PointCloud2:
    """The obstacle cells' features (3.4), all float32.

    x, y: mean of the points [m]; z: highest point [m], 0: unknown; min_height: lowest [m], NaN:
    unknown; density [points/m^2]; points: number, of all sensors; id: of the track on it, 0: none;
    moving: 1 if that moves.
    """
    grid = snapshot.grid
    owner = owners(snapshot)
    known = owner >= 0
    tracks = snapshot.tracks
    values = {
        "x": grid.position[:, 0],
        "y": grid.position[:, 1],
        "z": np.nan_to_num(grid.height[:, 1]),
        "min_height": grid.height[:, 0],
        "density": grid.density,
        "points": grid.counts.sum(axis=1),
        "id": np.where(known, np.append(tracks.id, 0)[owner], 0),
        "moving": known & np.append(tracks.moving, False)[owner],
    }
    table = np.stack([values[name] for name in CELL_FIELDS], axis=1).astype("<f4")
    fields = [PointField(name, 4 * i, PointField.FLOAT32, 1) for i, name in enumerate(CELL_FIELDS)]
    step, count = 4 * len(CELL_FIELDS), len(table)
    return PointCloud2(header, 1, count, fields, False, step, step * count, table.tobytes(), False)


def owners(snapshot: Snapshot) -> np.ndarray:
    """Index of the observed track on each obstacle cell (K,), -1: none; of several, the last."""
    grid, shapes = snapshot.grid, snapshot.shapes
    at = grid.cells_of(shapes.values)
    place = np.searchsorted(grid.cell, at)
    hit = (snapshot.tracks.misses[shapes.owner] == 0) & (place < len(grid.cell))
    hit[hit] = grid.cell[place[hit]] == at[hit]
    owner = np.full(len(grid.cell), -1)
    owner[place[hit]] = shapes.owner[hit]
    return owner
