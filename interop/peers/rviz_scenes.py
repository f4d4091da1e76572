"""Scenes that rviz and our page draw for the same messages: what each shows, seen from above at 50 pixels per metre."""

from __future__ import annotations

import random
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from pyros1.msgs.geometry_msgs.msg import (
    Point,
    Point32,
    PointStamped,
    Polygon,
    PolygonStamped,
    Pose,
    PoseArray,
    PoseStamped,
    Quaternion,
    TransformStamped,
    Vector3,
)
from pyros1.msgs.nav_msgs.msg import GridCells, OccupancyGrid, Odometry, Path
from pyros1.msgs.sensor_msgs.msg import LaserScan, PointCloud2, PointField, Range
from pyros1.msgs.std_msgs.msg import ColorRGBA
from pyros1.msgs.visualization_msgs.msg import Marker, MarkerArray

Colour = tuple[float, float, float, float]
TOP = {"Class": "rviz/TopDownOrtho", "X": 0, "Y": 0, "Scale": 50, "Angle": 0}
ASIDE = {"Class": "rviz/Orbit", "Distance": 6, "Focal Point": {"X": 0, "Y": 0, "Z": 0}, "Pitch": 0.6, "Yaw": 0.9}
RED, GREEN, BLUE, YELLOW = (1.0, 0.0, 0.0, 1.0), (0.0, 1.0, 0.0, 1.0), (0.0, 0.0, 1.0, 1.0), (1.0, 1.0, 0.0, 1.0)
FOUR = [RED, GREEN, BLUE, YELLOW]
ZIGZAG = [(-0.7, -0.7, 0.0), (0.0, 0.7, 0.0), (0.7, -0.7, 0.0), (0.7, 0.7, 0.0)]
CORNERS = [*ZIGZAG[:1], (0.7, -0.7, 0.0), (0.0, 0.7, 0.0), (0.7, 0.7, 0.0), (0.2, 0.7, 0.0), (0.7, 0.0, 0.0)]
BAR = [(-0.7, 0.0, 0.0), (0.7, 0.0, 0.0)]


class Scene(NamedTuple):
    """What is published, and how it is shown.

    Attributes:
        messages: (topic, message); all are in the frame map.
        displays: rviz's displays, without "Enabled".
        view: rviz's view.
        frames: transforms.
    """

    messages: list[tuple[str, Any]]
    displays: list[dict[str, Any]]
    view: dict[str, Any] = TOP
    frames: list[TransformStamped] = []


class Markers:
    """Markers in places of a picture."""

    def __init__(self) -> None:
        self.all: list[Marker] = []

    def add(
        self, x: float, y: float, kind: int, scale: Sequence[float], color: Colour = RED, points: Any = (),
        colors: Sequence[Colour] = (), **more: Any,
    ) -> None:  # fmt: skip
        """Add a marker at a place of the ground."""
        marker = Marker(ns="m", id=len(self.all), type=kind, **more)
        marker.pose = pose(x, y)
        marker.scale = Vector3(*map(float, scale))
        marker.color = ColorRGBA(*color)
        marker.points = [Point(*map(float, each)) for each in points]
        marker.colors = [ColorRGBA(*each) for each in colors]
        marker.header.frame_id = "map"
        self.all.append(marker)

    def scene(self, name: str) -> Scene:
        """Return the scene of these markers on a topic."""
        display = {"Class": "rviz/MarkerArray", "Name": "Markers", "Marker Topic": f"/{name}"}
        return Scene([(f"/{name}", MarkerArray(self.all))], [display])


def pose(x: float, y: float, z: float = 0.0) -> Pose:
    """Return a pose that is not turned."""
    return Pose(Point(x, y, z), Quaternion(0.0, 0.0, 0.0, 1.0))


def frame(parent: str, child: str, x: float = 0.0, y: float = 0.0) -> TransformStamped:
    """Return a transform that does not turn."""
    message = TransformStamped(child_frame_id=child)
    message.header.frame_id = parent
    message.transform.translation.x, message.transform.translation.y = x, y
    message.transform.rotation.w = 1.0
    return message


def kinds_of_markers() -> Scene:
    """Lines with widths, lists with colours, points with sizes, solids, arrows in both forms."""
    some = Markers()
    for y, kwargs in ((3, {}), (1, {"colors": FOUR})):
        some.add(-6, y, 4, (0.3, 0, 0), points=ZIGZAG, **kwargs)
        some.add(-4, y, 5, (0.3, 0, 0), points=ZIGZAG, **kwargs)
        some.add(-2, y, 6, (0.4, 0.3, 0.2), points=ZIGZAG, **kwargs)
        some.add(0, y, 7, (0.4, 0.5, 0.4), points=ZIGZAG, **kwargs)
        some.add(2, y, 8, (0.4, 0.2, 0), points=ZIGZAG, **kwargs)
        some.add(4, y, 11, (1, 1, 1), points=CORNERS, colors=[*FOUR, RED, GREEN] if kwargs else ())
    some.add(6, 3, 1, (1.2, 0.8, 1))
    some.add(6, 1, 2, (1.2, 0.8, 1), GREEN)
    some.add(-6, -1, 0, (1.5, 0.3, 0.3))
    some.add(-4, -1, 0, (0.2, 0.5, 0.5), points=BAR)
    some.add(-2, -1, 0, (0.2, 0.5, 0), points=BAR)
    some.add(0, -1, 3, (1, 1.4, 0.2), BLUE)
    some.add(2, -1, 0, (-1, 0.2, 0.2), YELLOW)
    some.add(4, -1, 11, (0.5, 1, 1), points=CORNERS, colors=[GREEN, BLUE])
    some.add(6, -1, 0, (0.2, 0.6, 4), points=BAR)
    return some.scene("kinds")


def scales_of_0() -> Scene:
    """What has no size, or colours that do not fit: nothing is drawn, but flat solids are."""
    some = Markers()
    for x, kind in zip((-6, -4, -2, 0, 2, 4, 6), (4, 5, 6, 7, 8, 11, 1), strict=True):
        some.add(x, 3, kind, (0, 0, 0), points=CORNERS)
    some.add(-6, 1, 0, (1.4, 0, 0))
    some.add(-4, 1, 8, (0.4, 0, 0), points=ZIGZAG)
    some.add(-2, 1, 8, (0, 0.4, 0), points=ZIGZAG)
    some.add(0, 1, 4, (-0.3, 0, 0), points=ZIGZAG)
    some.add(2, 1, 0, (0.2, 0.5, 0), points=BAR[:1])
    some.add(4, 1, 5, (0.3, 0, 0), points=ZIGZAG[:3])
    some.add(6, 1, 11, (1, 1, 1), points=CORNERS[:5])
    for x, kind in zip((-6, -4, -2, 0, 2), (4, 5, 6, 7, 8), strict=True):
        some.add(x, -1, kind, (0.3, 0.3, 0.3), points=ZIGZAG, colors=FOUR[:2])
    for x, kind in zip((-6, -4, -2), (1, 2, 3), strict=True):
        some.add(x, -3, kind, (1, 1, 0))
    some.add(0, -3, 6, (0.4, 0.4, 0), points=ZIGZAG)
    some.add(2, -3, 7, (0.4, 0.4, 0), points=ZIGZAG)
    return some.scene("zero")


GREEN_SQUARE = """<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="1"/><up_axis>Z_UP</up_axis></asset>
<library_effects><effect id="e"><profile_COMMON><technique sid="t"><lambert><diffuse><color>0 1 0 1</color></diffuse>
</lambert></technique></profile_COMMON></effect></library_effects>
<library_materials><material id="m"><instance_effect url="#e"/></material></library_materials>
<library_geometries><geometry id="g"><mesh><source id="p">
<float_array id="a" count="12">-.5 -.5 0 .5 -.5 0 .5 .5 0 -.5 .5 0</float_array><technique_common>
<accessor source="#a" count="4" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<source id="q"><float_array id="b" count="3">0 0 1</float_array><technique_common>
<accessor source="#b" count="1" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices><triangles count="2" material="m">
<input semantic="VERTEX" source="#v" offset="0"/><input semantic="NORMAL" source="#q" offset="1"/>
<p>0 0 1 0 2 0 0 0 2 0 3 0</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#g"><bind_material><technique_common>
<instance_material symbol="m" target="#m"/></technique_common></bind_material></instance_geometry></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>"""
"""A square of 1 m with a material of its own, which is ``package://squares/green.dae`` for scenes."""


def meshes() -> Scene:
    """Meshes with their own materials, tinted or not, and without; scales."""
    some = Markers()
    square = {"mesh_resource": "package://squares/green.dae"}
    clear, white, black = (0.0, 0.0, 0.0, 0.0), (1.0, 1.0, 1.0, 1.0), (0.0, 0.0, 0.0, 1.0)
    half, little = (1.0, 0.0, 0.0, 0.5), (0.0, 0.0, 1.0, 0.3)
    tints: list[Colour] = [clear, white, RED, half, black, (1.0, 1.0, 1.0, 0.0), little]
    for index, tint in enumerate(tints):
        some.add(2 * index - 6, 2, 10, (1, 1, 1), tint, **square, mesh_use_embedded_materials=True)
        some.add(2 * index - 6, 0, 10, (1, 1, 1), tint, **square)
    for x, scale in ((-6, (0, 0, 0)), (-4, (1, 1, 0)), (-2, (0, 1, 1)), (0, (-1, 1, 1)), (2, (1.5, 0.5, 1))):
        some.add(x, -2, 10, scale, **square)
    return some.scene("meshes")


def see_through() -> Scene:
    """The opacity of markers, and of each of their points."""
    some = Markers()
    for y, kind in zip((4, 3, 2, 1, 0), (4, 5, 6, 7, 8), strict=True):
        _opacities(some, y, kind, BAR, 2)
    _opacities(some, -1, 11, CORNERS[:3], 3)
    _opacities(some, -2.6, 11, CORNERS[:3], 1)
    for x, alpha in zip((-6, -4, -2, 0), (0.7, 0.5, 0.3, 0), strict=True):
        some.add(x, -4, 1, (1, 1, 0.1), (0, 1, 0, alpha))
    return some.scene("opacity")


def _opacities(some: Markers, y: float, kind: int, points: Any, count: int) -> None:
    half, little = (0.0, 1.0, 0.0, 0.5), (0.0, 1.0, 0.0, 0.3)
    for x, color, colors in (
        (-6, half, []),
        (-4, (1.0, 0.0, 0.0, 0.5), [GREEN] * count),
        (-2, (1.0, 0.0, 0.0, 0.5), [little] * count),
        (0, RED, [little] * count),
        (2, (1.0, 0.0, 0.0, 0.0), [GREEN] * count),
        (4, (1.0, 0.0, 0.0, 0.0), [little] * count),
        (6, (0.0, 1.0, 0.0, 0.0), []),
    ):
        size = (0.5, 0.5, 0.5) if kind != 11 else (1, 1, 1)
        some.add(x, y, kind, size, color, points, colors)


def clouds_and_scans() -> Scene:
    """Styles of points, sizes in metres and pixels, and colours of numbers."""
    messages, displays = [], []
    bounds = {"Autocompute Intensity Bounds": False, "Min Intensity": 0.2, "Max Intensity": 0.4}
    flat = {"Color Transformer": "FlatColor", "Color": "255; 255; 0"}
    axis = {"Color Transformer": "AxisColor", "Axis": "X"}
    limits = {"Autocompute Value Bounds": {"Min Value": -2, "Max Value": 0, "Value": False}}
    mixed = {"Use rainbow": False, "Min Color": "0; 0; 0", "Max Color": "255; 255; 0"}
    for index, more in enumerate((
        {"Style": "Squares"}, {"Style": "Spheres"}, {"Style": "Boxes"}, {"Style": "Points", "Size (Pixels)": 15},
        {"Style": "Squares", "Color Transformer": "AxisColor"}, {"Style": "Squares", **axis, **limits},
        {"Style": "Squares", "Invert Rainbow": True}, {"Style": "Squares", **mixed}, {"Style": "Squares", **bounds},
        {"Style": "Flat Squares", **flat, "Size (m)": 0.2},
    )):  # fmt: skip
        name = f"/cloud{index}"
        places = [[-3 + step, 4.5 - index, step * 0.2, step * 0.1] for step in range(7)]
        messages.append((name, cloud(places)))
        displays.append({"Class": "rviz/PointCloud2", "Name": name, "Topic": name, "Size (m)": 0.4, **more})
    scan = LaserScan(angle_min=-1.0, angle_max=1.0, angle_increment=0.5, range_max=20.0)
    scan.ranges, scan.intensities = [5.0] * 5, [0.0, 25.0, 50.0, 75.0, 100.0]
    messages.append(("/beams", scan))
    displays.append({"Class": "rviz/LaserScan", "Name": "beams", "Topic": "/beams", "Style": "Boxes", "Size (m)": 0.4})
    return Scene(messages, displays)


def cloud(places: Sequence[Sequence[float]]) -> PointCloud2:
    """Return points with x, y, z and an intensity."""
    fields = [PointField(name, 4 * index, 7, 1) for index, name in enumerate(("x", "y", "z", "intensity"))]
    data = np.array(places, np.float32).tobytes()
    return PointCloud2(height=1, width=len(places), fields=fields, point_step=16, row_step=len(data), data=data)


def paths_and_poses() -> Scene:
    """Styles of lines and of poses."""
    messages: list[tuple[str, Any]] = []
    displays: list[dict[str, Any]] = []

    def show(kind: str, message: Any, **more: Any) -> None:
        name = f"/step{len(messages)}"
        messages.append((name, message))
        red = {} if kind == "Odometry" else {"Color": "255; 0; 0"}
        displays.append({"Class": f"rviz/{kind}", "Name": name, "Topic": name, **red, **more})

    def path(y: float, **more: Any) -> None:
        poses = [PoseStamped(pose=pose(x, y + x % 2 * 0.6)) for x in (-5.0, -4.0, -3.0, -2.0)]
        for each in poses:
            each.header.frame_id = "map"
        show("Path", Path(poses=poses), **more)

    path(4)
    path(3, **{"Line Style": "Billboards", "Line Width": 0.2})
    path(2, **{"Pose Style": "Axes", "Length": 0.6, "Radius": 0.1})
    arrows = {"Shaft Length": 0.4, "Shaft Diameter": 0.2, "Head Length": 0.3, "Head Diameter": 0.4}
    path(1, **{"Pose Style": "Arrows", "Pose Color": "0; 255; 255", **arrows})
    path(0, **{"Line Style": "Billboards", "Line Width": 0.2, "Offset": {"X": 1, "Y": -0.5, "Z": 3}})
    thick = {"Shaft Length": 0.7, "Shaft Radius": 0.3, "Head Length": 0.4, "Head Radius": 0.6}
    show("Pose", PoseStamped(pose=pose(1, 4)), **thick)
    show("Pose", PoseStamped(pose=pose(4, 4)), Shape="Axes", **{"Axes Length": 0.8, "Axes Radius": 0.2})
    show("PoseArray", PoseArray(poses=[pose(1, 2.5), pose(3, 2.5)]), Shape="Arrow (3D)", **thick)
    show("PoseArray", PoseArray(poses=[pose(5, 2.5)]), Shape="Axes", **{"Axes Length": 0.6, "Axes Radius": 0.2})
    show("PoseArray", PoseArray(poses=[pose(1, 1)]), Shape="Arrow (Flat)", **{"Arrow Length": 1})
    place = {"Value": True, "Scale": 2, "Color": "0; 0; 255", "Alpha": 0.9}
    covariance = {"Value": True, "Position": place, "Orientation": {"Value": False}}
    shape = {"Value": "Axes", "Axes Length": 1, "Axes Radius": 0.2}
    odometry = Odometry()
    odometry.pose.pose = pose(3, -1)
    odometry.pose.covariance[0], odometry.pose.covariance[7], odometry.pose.covariance[14] = 0.25, 0.09, 0.01
    show("Odometry", odometry, Covariance=covariance, Shape=shape)
    return Scene(messages, displays)


def maps_and_areas() -> Scene:
    """Colours of cells, opacity, what is behind; and other displays of areas."""
    messages: list[tuple[str, Any]] = []
    displays: list[dict[str, Any]] = []

    def show(kind: str, message: Any, **more: Any) -> None:
        name = f"/area{len(messages)}"
        messages.append((name, message))
        displays.append({"Class": f"rviz/{kind}", "Name": name, "Topic": name, **more})

    def grid(x: float, y: float, cells: list[int], **more: Any) -> None:
        message = OccupancyGrid(data=cells * 2)
        message.info.width, message.info.height, message.info.resolution = len(cells), 2, 0.5
        message.info.origin = pose(x, y)
        show("Map", message, **more)

    usual, strange = [0, 1, 50, 99, 100, -1, 0], [-2, -128, 101, 127, 98, -100, 110]
    for y, scheme in ((3.6, "map"), (2.4, "costmap"), (1.2, "raw")):
        for x, cells, alpha in ((-6, usual, 1), (-2, usual, 0.7), (2, strange, 1)):
            grid(x, y, cells, **{"Color Scheme": scheme, "Alpha": alpha})
    boxes = Markers()
    for x in (-5, -1):
        boxes.add(x, 0, 1, (1, 1, 0.1))
    markers = boxes.scene("boxes")
    grid(-6, -0.5, usual, **{"Draw Behind": True, "Alpha": 0.7})
    grid(-2, -0.5, usual, Alpha=0.7)
    green = {"Color": "0; 255; 0"}
    show("PointStamped", PointStamped(point=Point(-5.0, -2.0, 0.0)), Radius=0.4, **green)
    corners = [Point32(-4.0, -2.5, 0.0), Point32(-3.0, -2.5, 0.0), Point32(-3.0, -1.5, 0.0)]
    show("Polygon", PolygonStamped(polygon=Polygon(corners)), **green)
    show("GridCells", GridCells(cell_width=0.5, cell_height=0.3, cells=[Point(-2.0, -2.0, 0.0)]), **green)
    seen = Range(field_of_view=0.5, min_range=0.1, max_range=5.0, range=2.0)
    show("Range", seen, **{"Color": "255; 0; 0", "Alpha": 1})
    return Scene([*messages, *markers.messages], [*displays, *markers.displays])


def frames() -> Scene:
    """Axes of frames."""
    tf = {"Class": "rviz/TF", "Name": "TF", "Marker Scale": 8, "Show Names": False, "Show Arrows": False}
    transforms = [frame("map", "left", -1.5, 1.0), frame("map", "right", 1.5, -1.0)]
    return Scene([], [tf], TOP, transforms)


def grid_behind_the_eye() -> Scene:
    """A grid that reaches behind the eye."""
    grid = {"Class": "rviz/Grid", "Name": "Grid", "Color": "255; 0; 255", "Alpha": 1, "Plane Cell Count": 20}
    broad = {"Line Style": {"Value": "Billboards", "Line Width": 0.05}}
    return Scene([], [{**grid, **broad}], {**ASIDE, "Distance": 3, "Pitch": 0.3})


def from_aside() -> Scene:
    """Solids, lines and points in perspective."""
    some = Markers()
    some.add(0, 0, 4, (0.3, 0, 0), points=[(-8, -1, 0), (8, -1, 0)], color=YELLOW)
    some.add(-1, 1, 2, (1, 1, 1), GREEN)
    some.add(0, 0, 0, (1.5, 0.3, 0.3), (0.0, 1.0, 1.0, 1.0))
    scene = some.scene("aside")
    balls = {"Class": "rviz/PointCloud2", "Name": "balls", "Topic": "/balls", "Style": "Spheres", "Size (m)": 0.4}
    points = cloud([[-3 + step, -2.5, 0.0, step] for step in range(7)])
    return Scene([*scene.messages, ("/balls", points)], [*scene.displays, balls], ASIDE)


def any_markers(seed: int) -> Scene:
    """Markers of any kind, size and colour, each in a place of its own; their points do not cover each other."""
    chance = random.Random(seed)
    some = Markers()
    for x in range(-6, 7, 2):
        for y in range(-4, 5, 2):
            kind = chance.choice([0, 1, 2, 3, 4, 5, 6, 7, 8, 11])
            if kind == 11:  # around to the left: rviz has little light for the other side
                points = [(-0.6, -chance.random(), 0.0), (0.6, -chance.random(), 0.0), (0.0, chance.random(), 0.0)]
            elif kind == 4:
                points = [(step, chance.uniform(-0.6, 0.6), 0.0) for step in (-0.6, -0.2, 0.2, 0.6)]
            else:
                points = [(across, up, 0.0) for up in (0.4, -0.4) for across in (-0.4, 0.4)]
                points = points[: 2 * chance.randint(0 if kind == 0 else 1, 1 if kind == 0 else 2)]
            greatest = 0.35 if kind in (4, 5, 6, 7, 8) else 0.7
            signs = [0.0, 1, 1] if kind in (2, 3, 11) else [0.0, 1, 1, -1]  # rviz has no light for the inside of solids
            size = [chance.choice(signs) * chance.uniform(0.2, greatest) for _ in range(3)]
            colors = [_any(chance) for _ in range(chance.choice([0, len(points), 1]))] if kind > 3 else []
            some.add(x, y, kind, size, (*_any(chance)[:3], chance.choice([0.0, 1.0, 1.0])), points, colors)
    return some.scene("any")


def _any(chance: random.Random) -> Colour:
    red, green, blue = (chance.choice([0.0, 1.0]) for _ in range(3))
    return red, green, blue, 1.0


_ALL = (kinds_of_markers, scales_of_0, see_through, clouds_and_scans, paths_and_poses, maps_and_areas, frames)
SCENES = {each.__name__: each for each in (*_ALL, meshes, grid_behind_the_eye, from_aside)}
