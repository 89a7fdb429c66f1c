"""What the obstacle tracker publishes; what nobody reads is not made."""

from __future__ import annotations

from typing import Callable

import rospy
from nav_msgs.msg import OccupancyGrid
from sensor_msgs.msg import PointCloud2
from visualization_msgs.msg import MarkerArray

from safe_passage.monitoring.persons import Persons
from safe_passage.monitoring.pipeline import Snapshot
from safe_passage.msg import PersonArray, TrackedObstacleArray
from safe_passage.ros.conversions import to_header
from safe_passage.ros.fields_of_view import FieldOfView
from safe_passage.ros.tracker_bridges import make_bridges
from safe_passage.ros.tracker_conversions import to_cells, to_occupancy, to_tracks
from safe_passage.ros.tracker_markers import TrackerMarkers
from safe_passage.ros.tracker_parameters import TrackerNodeParameters
from safe_passage.ros.tracker_persons import to_person_array


class TrackerOutputs:
    """All publishers."""

    def __init__(self, parameters: TrackerNodeParameters) -> None:
        self._p = parameters
        self._tracks = rospy.Publisher("tracks", TrackedObstacleArray, queue_size=1)
        self._persons = rospy.Publisher("tracked_persons", PersonArray, queue_size=10)
        self._bridges = make_bridges()
        self._grid = rospy.Publisher("~grid", OccupancyGrid, queue_size=1)
        self._cells = rospy.Publisher("~cells", PointCloud2, queue_size=1)
        self._markers_pub = rospy.Publisher("~markers", MarkerArray, queue_size=1)
        self._markers = TrackerMarkers(parameters)
        self._drawn = rospy.Time()

    def publish(
        self,
        snapshot: Snapshot,
        persons: Persons,
        stamp: rospy.Time,
        fields_of_view: Callable[[], list[FieldOfView]],
    ) -> None:
        """One cycle's results; `stamp` is the snapshot's."""
        in_base, in_odom = (
            to_header(stamp, frame) for frame in (self._p.base_frame, self._p.odom_frame)
        )
        if self._tracks.get_num_connections():
            self._tracks.publish(to_tracks(snapshot, persons, in_base, self._p))
        if self._p.person_sources and self._persons.get_num_connections():
            self._persons.publish(to_person_array(snapshot, persons, in_odom))
        for bridge in self._bridges:
            if bridge.publisher.get_num_connections():
                bridge.publisher.publish(bridge.make(snapshot, persons, in_odom))
        if (stamp - self._drawn).to_sec() * self._p.debug_rate < 0.99:
            return
        self._drawn = stamp
        if self._grid.get_num_connections():
            self._grid.publish(to_occupancy(snapshot.grid, in_base))
        if self._cells.get_num_connections():
            self._cells.publish(to_cells(snapshot, in_base))
        if self._markers_pub.get_num_connections():
            markers = self._markers.draw(snapshot, persons, in_base, in_odom, fields_of_view())
            self._markers_pub.publish(markers)

    def tune(self, parameters: TrackerNodeParameters) -> None:
        """Other parameters from the next cycle on; the ways drawn so far stay."""
        self._p = parameters
        self._markers.tune(parameters)

    def restart(self) -> None:
        """Forget what was published; stamps may be older from now on."""
        self._drawn = rospy.Time()
        self._markers = TrackerMarkers(self._p)
