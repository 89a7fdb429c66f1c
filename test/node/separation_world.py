"""A robot that stands, people around it as a tracker tells them, and a planner that commands."""

import numpy as np
import rospy
from geometry_msgs.msg import Point, PoseStamped, Quaternion, Twist, Vector3
from nav_msgs.msg import Odometry, Path
from rosgraph_msgs.msg import Clock
from safe_passage.msg import TrackedObstacle, TrackedObstacleArray
from safe_passage.ros.conversions import to_header, to_transform
from tf2_msgs.msg import TFMessage

ODOM, BASE = "robot1/odom", "robot1/base_link"
ARM = {"robot1/shoulder": (0.3, 0.0, 0.8), "robot1/hand": (0.5, 0.0, 1.0)}  # [m] in base
TICK = 0.05  # [s] of simulated time
CELL = 0.1  # [m]
ALL = ("tf", "arm", "odom", "tracks", "command")


class World:
    """Makes the clock, and everything that the monitor reads."""

    def __init__(self):
        self._ticks = 2000
        self.began = 0.0  # [s] when the tracks began
        self._publishers = {
            name: rospy.Publisher(topic, kind, queue_size=50)
            for name, topic, kind in (
                ("clock", "/clock", Clock),
                ("tf", "/tf", TFMessage),
                ("odom", "odom", Odometry),
                ("tracks", "tracks", TrackedObstacleArray),
                ("command", "cmd_vel_raw", Twist),
                ("plan", "plan", Path),
            )
        }
        self.calm()

    def calm(self):
        """Somebody far away, and the planner wants ahead."""
        self.people = [(8.0, 8.0, 0.0, 0.0)]  # (x, y, vx, vy), base
        self.command = (0.5, 0.0, 0.0)  # forward, left, turn
        self.first_id = 1
        self.sensors = {"laser": True, "camera": True}  # name -> alive

    def set_back(self, seconds):
        """The clock to `seconds`."""
        self._ticks = round(seconds / TICK)

    @property
    def stamp(self):
        """Now."""
        milliseconds = 50 * self._ticks
        return rospy.Time(milliseconds // 1000, 10**6 * (milliseconds % 1000))

    def tick(self, without=(), **spoilt):
        """A step of time, at which all speak but those in `without`; returns its stamp.

        spoilt: what is done to a message of that name before it is sent.
        """
        self._ticks += 1
        self._publishers["clock"].publish(self.stamp)
        for name in ALL:
            if name not in without:
                self.send(name, spoilt.get(name, lambda message: None))
        return self.stamp

    def send(self, name, spoil=lambda message: None):
        """One message as of now."""
        message = getattr(self, "_" + name)()
        spoil(message)
        self._publishers["tf" if name == "arm" else name].publish(message)

    def send_plan(self, points, frame=ODOM, age=0.0):
        """A path through `points` (x, y) [m]."""
        header = to_header(self.stamp - rospy.Duration.from_sec(age), frame)
        path = Path(header=header)
        for x, y in points:
            place = PoseStamped(header=header)
            place.pose.position, place.pose.orientation = Point(x, y, 0.0), Quaternion(0, 0, 0, 1)
            path.poses.append(place)
        self._publishers["plan"].publish(path)

    def _tf(self):
        return TFMessage([to_transform(to_header(self.stamp, ODOM), BASE, (0.0, 0.0, 0.0))])

    def _arm(self):
        header = to_header(self.stamp, BASE)
        return TFMessage([to_transform(header, child, place) for child, place in ARM.items()])

    def _odom(self):
        return Odometry(header=to_header(self.stamp, ODOM), child_frame_id=BASE)

    def _command(self):
        twist = Twist()
        twist.linear.x, twist.linear.y, twist.angular.z = self.command
        return twist

    def _tracks(self):
        array = TrackedObstacleArray(header=to_header(self.stamp, BASE), resolution=CELL)
        array.sensors, array.alive = list(self.sensors), list(self.sensors.values())
        body = CELL * (np.stack(np.meshgrid([-1.0, 0.0, 1.0], [-1.0, 0.0, 1.0]), -1).reshape(-1, 2))
        for i, (x, y, vx, vy) in enumerate(self.people):
            cells = body + np.array([x, y])
            array.obstacles.append(
                TrackedObstacle(
                    id=self.first_id + i,
                    age=self.stamp.to_sec() - self.began,
                    observed=True,
                    moving=True,
                    position=Point(x, y, 0.0),
                    velocity=Vector3(vx, vy, 0.0),
                    covariance=(0.01 * np.eye(4)).ravel(),
                    cells_x=cells[:, 0],
                    cells_y=cells[:, 1],
                )  # fmt: skip
            )
        return array
