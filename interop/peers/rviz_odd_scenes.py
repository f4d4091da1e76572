"""Scenes of odd messages that rviz and our page draw alike: signs, sizes and counts that publishers get wrong."""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from typing import Any

from rviz_scenes import BAR, CORNERS, GREEN, ZIGZAG, Markers, Scene, frame, pose

from pyros1.msgs.geometry_msgs.msg import (
    Point,
    Point32,
    PointStamped,
    Polygon,
    PolygonStamped,
    PoseArray,
    PoseStamped,
    Quaternion,
    Vector3,
    WrenchStamped,
)
from pyros1.msgs.nav_msgs.msg import OccupancyGrid
from pyros1.msgs.sensor_msgs.msg import ChannelFloat32, LaserScan, PointCloud, PointCloud2, PointField, Range

NAN, INFINITY = math.nan, math.inf
_SIX = [(x, y, 0.0) for y in (-0.3, 0.3) for x in (-0.5, 0.0, 0.5)]
_SIZES = {"B": 2, "I": 6, "f": 7, "d": 8}


class Parts:
    """Messages, each with its display."""

    def __init__(self, name: str) -> None:
        self._name = name  # of topics and frames: rviz remembers those of other scenes
        self.messages: list[tuple[str, Any]] = []
        self.displays: list[dict[str, Any]] = []
        self.frames: list[Any] = []

    def add(self, kind: str, message: Any, at: tuple[float, float] | None = None, **more: Any) -> None:
        """Add a message; "at" is where its frame is, if that is not the fixed one."""
        name = f"/{self._name}{len(self.messages)}"
        if at is not None:
            message.header.frame_id = name[1:]
            self.frames.append(frame("map", name[1:], *at))
        self.messages.append((name, message))
        self.displays.append({"Class": f"rviz/{kind}", "Name": name, "Topic": name, **more})

    def scene(self) -> Scene:
        """Return all of them, seen from above."""
        return Scene(self.messages, self.displays, frames=self.frames)


def odd_markers() -> Scene:
    """Negative sizes, orientations of any length, arrows with too many points, colours beyond 1, short lifetimes."""
    some = Markers()
    for x, kind in zip((-6, -4, -2, 0), range(4), strict=True):
        some.add(x, 3, kind, (-1, -0.6, -0.4))
    for x, kind in ((2, 6), (4, 7), (6, 8)):
        some.add(x, 3, kind, (-0.3, -0.5, -0.3), points=ZIGZAG)
    for x, scale in zip((-6, -4, -2), ((-0.2, 0.5, 0.3), (0.2, -0.5, 0.3), (0.2, 0.5, -0.3)), strict=True):
        some.add(x, 1, 0, scale, points=BAR)
    some.add(0, 1, 0, (0.2, 0.5, 0.3), points=[*BAR, (0, 0.7, 0)])
    for x, kind, points in ((2, 4, ZIGZAG), (4, 1, ()), (6, 0, ())):
        some.add(x, 1, kind, (0.3 if kind == 4 else 1.2, 0.5, 0.4), points=points)
    turns = [(0.0, 0.0, 1e-9, 1e-9), (0.0, 0.0, 2.0, 1.0), (0.0, 0.0, 0.0, 0.0)]
    for marker, turn in zip(some.all[-3:], turns, strict=True):
        marker.pose.orientation = Quaternion(*turn)
    for x, colour in zip((-6, -4, -2, 0), ((2, 0.5, 0, 1), (-1, 1, 0, 1), (1, 0, 0, 2), (1, 0, 0, -1)), strict=True):
        some.add(x, -1, 1, (1, 1, 0.2), tuple(map(float, colour)))
    some.add(2, -1, 1, (1, 1, 0.2), GREEN)
    some.all[-1].lifetime.nsecs = 50
    some.add(4, -1, 11, (1, 1, 1), points=CORNERS, colors=[GREEN] * 5)
    return some.scene("odd")


def _cloud(at: tuple[float, float], name: str, kind: str, values: Sequence[Any], **more: Any) -> PointCloud2:
    rows = zip(_SIX, values, strict=True)
    data = b"".join(struct.pack(f"<fff{kind}", x + at[0], y + at[1], z, value) for (x, y, z), value in rows)
    fields = [PointField(axis, 4 * index, 7, 1) for index, axis in enumerate("xyz")]
    step = len(data) // 6
    known = {"height": 1, "width": 6, "point_step": step, "row_step": len(data), "data": data, **more}
    return PointCloud2(fields=[*fields, PointField(name, 12, _SIZES[kind], 1)], **known)


def odd_clouds() -> Scene:
    """Rows without a size, opacities, old names, three fields of colour, bounds the other way round."""
    some = Parts("cloud")
    big = {"Size (m)": 0.4, "Style": "Flat Squares"}
    rgb = {**big, "Color Transformer": "RGB8"}
    colours = [0xFF0000, 0xFF00FF00, 0x800000FF, 0x40FFFF00, 0xFFFFFFFF, 0xFF00FFFF]
    six = [0, 1, 2, 3, 4, 5]
    some.add("PointCloud2", _cloud((-6, 3), "rgba", "I", colours), **rgb)
    some.add("PointCloud2", _cloud((-4, 3), "rgba", "I", colours), **rgb, Alpha=0.5)
    some.add("PointCloud2", _cloud((-2, 3), "rgb", "I", colours), **rgb)
    some.add("PointCloud2", _cloud((0, 3), "rgb", "I", colours), **{**rgb, "Color Transformer": "MONO8"})
    by_value = {**big, "Color Transformer": "Intensity"}
    some.add("PointCloud2", _cloud((2, 3), "intensity", "f", six, row_step=0), **by_value)
    some.add("PointCloud2", _cloud((4, 3), "intensity", "B", six, row_step=7), **by_value)
    bounds = {"Autocompute Intensity Bounds": False, "Min Intensity": 4, "Max Intensity": 1}
    some.add("PointCloud2", _cloud((6, 3), "intensity", "d", six), **by_value, **bounds)
    for x, names, transformer in ((-6, ("intensities",), "Intensity"), (-4, ("r", "g", "b"), "RGBF32")):
        points = [Point32(a + x, b + 1, c) for a, b, c in _SIX]
        channels = [ChannelFloat32(name, [value / 5 for value in six]) for name in names]
        if transformer == "RGBF32":
            channels[2].values = [1.0] * 6
        some.add(
            "PointCloud", PointCloud(points=points, channels=channels), **big, **{"Color Transformer": transformer}
        )
    return some.scene()


def odd_scans() -> Scene:
    """Ranges at the bounds, decreasing angles, bounds that are not numbers, too many intensities."""
    some = Parts("scan")
    flat = {"Size (m)": 0.2, "Style": "Flat Squares", "Color Transformer": "FlatColor", "Color": "0; 255; 255"}
    usual = {"angle_min": -0.5, "angle_increment": 0.1, "range_min": 0.1, "range_max": 2.0}
    odd: list[dict[str, Any]] = [
        {"ranges": [1.0, 2.0, INFINITY, NAN, -1.0, 0.05, 0.1, 1.0]},
        {"ranges": [1.0] * 11, "angle_increment": -0.1, "angle_min": 0.5},
        {"ranges": [1.0] * 11, "range_max": INFINITY},
        {"ranges": [1.0] * 11, "range_max": 0.0},
        {"ranges": [1.0] * 11, "range_max": NAN},
        {"ranges": [1.0] * 11, "range_min": NAN},
        {"ranges": [1.0] * 11, "range_min": -5.0},
        {"ranges": [1.0] * 11, "angle_increment": NAN},
        {"ranges": [1.0] * 11, "angle_min": INFINITY},
        {"ranges": []},
    ]
    for index, more in enumerate(odd):
        some.add("LaserScan", LaserScan(**{**usual, **more}), (2 * (index % 7) - 6, 3 - 2 * (index // 7)), **flat)
    coloured = {**flat, "Color Transformer": "Intensity"}
    scan = LaserScan(**usual, ranges=[1.0] * 11, intensities=[float(value) for value in range(20)])
    some.add("LaserScan", scan, (2, 1), **coloured)
    return some.scene()


def odd_areas() -> Scene:
    """Maps with too few or too many cells, polygons along the axes, rangers, what is not finite, forces."""
    some = Parts("area")
    green, red = {"Color": "0; 255; 0"}, {"Color": "255; 0; 0"}
    for x, cells, turn in ((-6, [0, 50], 0.0), (-4, [0] * 20, 0.0), (0, [0, 50, 100, -1, 25, 99], 0.4)):
        message = OccupancyGrid(data=cells)
        message.info.width, message.info.height, message.info.resolution = 3, 2, 0.5
        message.info.origin = pose(x, 3)
        message.info.origin.orientation.z = turn
        some.add("Map", message, Alpha=1)
    for x, corners in ((-6, "0011"), (-4, "00100111"), (-2, "0020211101")):
        places = [(int(corners[index]), int(corners[index + 1])) for index in range(0, len(corners), 2)]
        points = [Point32(x + 0.51 * a, 1.51 + 0.5 * b, 0.0) for a, b in places]
        some.add("Polygon", PolygonStamped(polygon=Polygon(points)), **green)
    same = {"min_range": 1.0, "max_range": 1.0}
    rangers: list[dict[str, Any]] = [
        {"range": 1.0, **same},
        {"range": -INFINITY, **same},
        {"range": INFINITY, **same},
        {"range": INFINITY},
        {"range": 5.0},
    ]
    for x, more in zip((-6, -4, -2, 0, 2), rangers, strict=True):
        message = Range(**{"field_of_view": 0.5, "min_range": 0.1, "max_range": 2.0, **more})
        some.add("Range", message, (x, 0.5), Alpha=1, **red)
    thick = {"Shaft Length": 0.7, "Shaft Radius": 0.2, "Head Length": 0.4, "Head Radius": 0.4, **red}
    for x, turn in zip((-6, -4, -2), ((0, 0, 0, 0), (0, 0, 2, 2), (NAN, 0, 0, 1)), strict=True):
        one = pose(x, -1)
        one.orientation = Quaternion(*map(float, turn))
        some.add("Pose", PoseStamped(pose=one), **thick)
        some.add("PoseArray", PoseArray(poses=[one]), Shape="Arrow (3D)", **thick)
    some.add("PointStamped", PointStamped(point=Point(NAN, 0.0, 0.0)), Radius=0.4, **green)
    for x, force in ((-6.0, 1.0), (0.0, NAN)):
        wrench = WrenchStamped()
        wrench.wrench.force, wrench.wrench.torque = Vector3(force, 0.0, 0.0), Vector3(0.0, 0.0, 1.0)
        some.add("WrenchStamped", wrench, (x, -3), **{"Arrow Width": 4})
    return some.scene()


def hidden_frames() -> Scene:
    """Frames of which a file hides one."""
    tf = {"Class": "rviz/TF", "Name": "TF", "Marker Scale": 8, "Show Names": False, "Show Arrows": False}
    frames = [frame("map", "shown_frame", -3.0, 1.0), frame("map", "hidden_frame", 3.0, -1.0)]
    earlier = ("left", "right")  # of another scene: rviz still has them for some seconds
    hidden = {name: {"Value": False} for name in ("hidden_frame", *earlier)}
    return Scene([], [{**tf, "Frames": hidden}], frames=frames)


ODD_SCENES = {each.__name__: each for each in (odd_markers, odd_clouds, odd_scans, odd_areas, hidden_frames)}
