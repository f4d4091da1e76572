"""The topics of a simulated robot."""

from __future__ import annotations

from math import cos, isfinite, sin
from typing import Any

from pyros1.ground.timing import Time
from pyros1.msgs.geometry_msgs.msg import Quaternion, Transform, TransformStamped, Twist, Vector3
from pyros1.msgs.nav_msgs.msg import Odometry
from pyros1.msgs.sensor_msgs.msg import CameraInfo, Image, Imu, JointState, LaserScan
from pyros1.msgs.std_msgs.msg import Bool
from pyros1.node import Node
from pyros1.robot_nodes.flat_world.world import World
from pyros1.tf.rotation import from_angles

_Pose = tuple[float, float, float]
_IMU_HEIGHT = 0.1
_WHEEL_JOINTS = ["left_wheel_joint", "right_wheel_joint"]
_OPTICAL_ANGLES = (-1.5707963267948966, 0.0, -1.5707963267948966)
"""Roll, pitch and yaw of a frame whose z points forward and x to the right (REP 103)."""
_EXACT = 1e-9
"""Variance of exact values; some programs do not accept 0."""


class RobotTopics:
    """Publishes a robot's measurements, if they have subscribers, and receives its commands.

    Args:
        node: the node.
        world: the world.
        number: the robot's row in the world's arrays.
        namespace: the namespace of its topics and frames, such as "robot1/"; may be empty.
    """

    def __init__(self, node: Node, world: World, number: int, namespace: str) -> None:
        self._node, self._world, self._number = node, world, number
        self._odom_frame, self._base_frame = f"{namespace}odom", f"{namespace}base_footprint"
        self._laser_frame, self._imu_frame = f"{namespace}laser", f"{namespace}imu"
        self._camera_frame = f"{namespace}camera_optical"

        def advertise(topic: str, message_class: Any, **options: Any) -> Any:
            return node.advertise(f"{namespace}{topic}", message_class, **{"queue_size": 10, **options})

        self._odometry = advertise("odom", Odometry)
        self._truth = advertise("base_pose_ground_truth", Odometry)
        self._imu = advertise("imu/data", Imu)
        self._joints = advertise("joint_states", JointState)
        self._scan = advertise("scan", LaserScan)
        self._image = advertise("camera/image_raw", Image, queue_size=2)
        self._camera_info = advertise("camera/camera_info", CameraInfo, queue_size=2)
        self._bumper = advertise("bumper", Bool, latch=True)
        self._was_bumped: bool | None = None
        node.subscribe(f"{namespace}cmd_vel", Twist, self._on_command, queue_size=1)

    def _on_command(self, twist: Any) -> None:
        speed, turn = twist.linear.x, twist.angular.z
        if isfinite(speed) and isfinite(turn):
            self._world.command(self._number, speed, turn)
        else:
            self._node.log.warn("a command is ignored, since it is not a number: %s, %s", speed, turn, throttle=10)

    @property
    def wants_scan(self) -> bool:
        """Whether the laser scan has subscribers."""
        return bool(self._scan.num_connections)

    def publish_motion(self, stamp: Time) -> None:
        """Publish odometry, ground truth, IMU, wheels and bumper."""
        world, number = self._world, self._number
        if self._odometry.num_connections:
            pose, speeds = _floats(world.odometry[number]), _floats(world.wheel_speeds[number])
            self._odometry.publish(_make_odometry(stamp, self._odom_frame, self._base_frame, pose, speeds, 1e-3))
        if self._truth.num_connections:
            pose, speeds = _floats(world.poses[number]), _floats(world.speeds[number])
            self._truth.publish(_make_odometry(stamp, "map", self._base_frame, pose, speeds, _EXACT))
        if self._imu.num_connections:
            self._imu.publish(self._make_imu(stamp))
        if self._joints.num_connections:
            speeds = world.settings.drive.to_wheels(world.wheel_speeds[number : number + 1])[0]
            message = JointState(name=_WHEEL_JOINTS, position=_floats(world.wheel_angles[number]))
            message.velocity = _floats(speeds / world.settings.drive.wheel_radius)
            message.header.stamp = stamp
            self._joints.publish(message)
        bumped = bool(world.bumped[number])
        if bumped != self._was_bumped:
            self._was_bumped = bumped
            self._bumper.publish(Bool(bumped))

    def _make_imu(self, stamp: Time) -> Any:
        imu = self._world.settings.imu
        turn, *acceleration = _floats(self._world.imus[self._number])
        message = Imu(orientation=_rotation(float(self._world.poses[self._number, 2])))
        message.header.stamp, message.header.frame_id = stamp, self._imu_frame
        message.angular_velocity.z = turn
        message.linear_acceleration = Vector3(*acceleration)
        message.orientation_covariance = _diagonal(1e-6, 1e-6, 1e-4)
        message.angular_velocity_covariance = _diagonal(*[imu.turn_noise**2 + imu.turn_bias**2] * 3)
        message.linear_acceleration_covariance = _diagonal(*[imu.acceleration_noise**2] * 3)
        return message

    def publish_scan(self, stamp: Time, ranges: Any, period: float) -> None:
        """Publish a laser scan.

        Args:
            stamp: the time of the scan.
            ranges: in m; float32 with shape (rays,).
            period: seconds between scans.
        """
        laser = self._world.settings.laser
        angles = laser.angles
        message = LaserScan(
            angle_min=angles[0],
            angle_max=angles[-1],
            angle_increment=angles[1] - angles[0],
            scan_time=period,
            range_min=laser.min_range,
            range_max=laser.max_range,
            ranges=ranges,
        )
        message.header.stamp, message.header.frame_id = stamp, self._laser_frame
        self._scan.publish(message)

    def publish_picture(self, stamp: Time) -> None:
        """Publish the camera's image and camera_info."""
        camera = self._world.settings.camera
        if self._image.num_connections:
            image = Image(height=camera.height, width=camera.width, encoding="rgb8", step=3 * camera.width)
            image.data = self._world.picture(self._number).tobytes()
            image.header.stamp, image.header.frame_id = stamp, self._camera_frame
            self._image.publish(image)
        if self._camera_info.num_connections:
            focal, centre_x, centre_y = camera.focal_length, camera.width / 2 - 0.5, camera.height / 2 - 0.5
            info = CameraInfo(height=camera.height, width=camera.width, distortion_model="plumb_bob", D=[0.0] * 5)
            info.K = [focal, 0, centre_x, 0, focal, centre_y, 0, 0, 1]
            info.R = _diagonal(1, 1, 1)
            info.P = [focal, 0, centre_x, 0, 0, focal, centre_y, 0, 0, 0, 1, 0]
            info.header.stamp, info.header.frame_id = stamp, self._camera_frame
            self._camera_info.publish(info)

    def transforms(self, stamp: Time, with_map: bool) -> list[Any]:
        """Return the transform from odom to base and, if wanted, the one from map to odom that corrects drift."""
        odometry = _floats(self._world.odometry[self._number])
        found = [_make_transform(stamp, self._odom_frame, self._base_frame, odometry)]
        if with_map:
            pose = _floats(self._world.poses[self._number])
            found.append(_make_transform(stamp, "map", self._odom_frame, _difference(pose, odometry)))
        return found

    def sensor_transforms(self, stamp: Time) -> list[Any]:
        """Return the transforms from the robot's base to its sensors."""
        laser, camera = self._world.settings.laser, self._world.settings.camera
        optical = _make_transform(stamp, self._base_frame, self._camera_frame, (camera.x, 0.0, 0.0), camera.z)
        optical.transform.rotation = Quaternion(*from_angles(*_OPTICAL_ANGLES))
        return [
            _make_transform(stamp, self._base_frame, self._laser_frame, (laser.x, 0.0, 0.0), laser.z),
            _make_transform(stamp, self._base_frame, self._imu_frame, (0.0, 0.0, 0.0), _IMU_HEIGHT),
            optical,
        ]


def _floats(row: Any) -> Any:
    return tuple(row.tolist())


def _diagonal(*values: float) -> list[float]:
    size = len(values)
    matrix = [0.0] * (size * size)
    matrix[:: size + 1] = [float(value) for value in values]
    return matrix


def _rotation(heading: float) -> Any:
    return Quaternion(0.0, 0.0, sin(heading / 2), cos(heading / 2))


def _difference(pose: _Pose, other: _Pose) -> _Pose:
    """Return the pose of the frame relative to which ``other`` describes the same place and heading as ``pose``."""
    turn = pose[2] - other[2]
    x = pose[0] - other[0] * cos(turn) + other[1] * sin(turn)
    y = pose[1] - other[0] * sin(turn) - other[1] * cos(turn)
    return x, y, turn


def _make_transform(stamp: Time, parent: str, child: str, pose: _Pose, z: float = 0.0) -> Any:
    transform = TransformStamped(child_frame_id=child)
    transform.header.stamp, transform.header.frame_id = stamp, parent
    transform.transform = Transform(Vector3(pose[0], pose[1], z), _rotation(pose[2]))
    return transform


def _make_odometry(
    stamp: Time, frame: str, child_frame: str, pose: _Pose, speeds: tuple[float, float], variance: float
) -> Any:
    message = Odometry(child_frame_id=child_frame)
    message.header.stamp, message.header.frame_id = stamp, frame
    position = message.pose.pose.position
    position.x, position.y, heading = pose
    message.pose.pose.orientation = _rotation(heading)
    message.twist.twist.linear.x, message.twist.twist.angular.z = speeds
    # Height, roll and pitch of a robot on a floor are known.
    covariance = _diagonal(variance, variance, _EXACT, _EXACT, _EXACT, variance)
    message.pose.covariance = message.twist.covariance = covariance
    return message
