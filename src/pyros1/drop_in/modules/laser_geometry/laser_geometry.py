"""LaserProjection: converts laser scans to point clouds, with numpy."""

from __future__ import annotations

from typing import Any

import numpy as np
import rospy

from pyros1.msgs.sensor_msgs.msg import PointCloud2, PointField

_FLOAT, _INT = PointField.FLOAT32, PointField.INT32


class LaserProjection:
    """Projects laser scans to points. It caches the directions of the beams."""

    LASER_SCAN_INVALID = -1.0
    LASER_SCAN_MIN_RANGE = -2.0
    LASER_SCAN_MAX_RANGE = -3.0

    class ChannelOption:
        """Channels of the cloud besides x, y and z; add the values to select several."""

        NONE = 0x00
        INTENSITY = 0x01
        INDEX = 0x02
        DISTANCE = 0x04
        TIMESTAMP = 0x08
        VIEWPOINT = 0x10
        DEFAULT = INTENSITY | INDEX

    def __init__(self) -> None:
        self._cached_shape: tuple[int, float, float] | None = None
        self._directions = np.empty((2, 0))

    def projectLaser(
        self, scan_in: Any, range_cutoff: float = -1.0, channel_options: int = ChannelOption.DEFAULT
    ) -> Any:
        """Convert a sensor_msgs/LaserScan to a sensor_msgs/PointCloud2, in the frame of the scanner.

        Args:
            scan_in: the scan; ranges outside its limits are omitted.
            range_cutoff: in metres; ranges from this value on are omitted. If negative, only the scan's limits apply.
            channel_options: a sum of `ChannelOption` values; intensities are included only if the scan has them.

        Returns:
            A cloud of height 1, with one point for each valid range.

        Raises:
            IndexError: there are fewer intensities than ranges.
        """
        ranges = np.asarray(scan_in.ranges, np.float64)
        max_range = scan_in.range_max if range_cutoff < 0 else min(range_cutoff, scan_in.range_max)
        valid = np.flatnonzero((ranges >= scan_in.range_min) & (ranges < max_range))
        distance = ranges[valid]
        cosine, sine = self._beam_directions(len(ranges), scan_in)[:, valid]
        option = self.ChannelOption
        columns: list[tuple[str, int, Any]] = [("x", _FLOAT, distance * cosine), ("y", _FLOAT, distance * sine)]
        columns.append(("z", _FLOAT, 0.0))
        if channel_options & option.INTENSITY and len(scan_in.intensities) > 0:
            columns.append(("intensity", _FLOAT, np.asarray(scan_in.intensities, np.float32)[valid]))
        if channel_options & option.INDEX:
            columns.append(("index", _INT, valid))
        if channel_options & option.DISTANCE:
            columns.append(("distances", _FLOAT, distance))
        if channel_options & option.TIMESTAMP:
            columns.append(("stamps", _FLOAT, valid * scan_in.time_increment))
        if channel_options & option.VIEWPOINT:
            columns += [(name, _FLOAT, 0.0) for name in ("vp_x", "vp_y", "vp_z")]
        points = np.zeros(
            len(valid), [(name, "<f4" if data_type == _FLOAT else "<i4") for name, data_type, _ in columns]
        )
        for name, _, values in columns:
            points[name] = values
        return PointCloud2(
            header=scan_in.header,
            height=1,
            width=len(points),
            fields=[PointField(name, 4 * index, data_type, 1) for index, (name, data_type, _) in enumerate(columns)],
            is_dense=False,
            is_bigendian=False,
            point_step=points.itemsize,
            row_step=points.nbytes,
            data=points.tobytes(),
        )

    def _beam_directions(self, count: int, scan: Any) -> Any:
        """Return the cosine and sine of each beam's angle, as an array of shape (2, count)."""
        shape = (count, scan.angle_min, scan.angle_increment)
        if shape != self._cached_shape:
            angles = scan.angle_min + np.arange(count) * scan.angle_increment
            self._directions = np.array((np.cos(angles), np.sin(angles)))
            self._cached_shape = shape
        return self._directions
