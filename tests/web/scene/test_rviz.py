"""Files of rviz as settings of the 3D panel."""

from __future__ import annotations

import json
import math
import random

import pytest
import yaml

from pyros1.web.scene.rviz.file import MAX_FILE_SIZE, RvizFile, RvizFileError, read_rviz

pytestmark = pytest.mark.once

FILE = """
Panels:
  - {Class: rviz/Displays, Name: Displays}
  - {Class: my_panels/Buttons, Name: Buttons}
Visualization Manager:
  Class: ""
  Displays:
    - {Class: rviz/Grid, Enabled: true, Name: Grid, Cell Size: 0.5, Plane Cell Count: 10, Color: 0; 128; 255, Plane: XY,
       Reference Frame: <Fixed Frame>, Offset: {X: 0, Y: 0, Z: 0}}
    - {Class: rviz/RobotModel, Enabled: true, Name: RobotModel, Robot Description: robot_description, Alpha: 0.5,
       Visual Enabled: false, Collision Enabled: true, Links: {base_link: {Value: true}}}
    - {Class: rviz/TF, Enabled: false, Name: TF, Marker Scale: 2, Show Names: false, Show Arrows: true}
    - {Class: rviz/LaserScan, Enabled: true, Name: Scan, Topic: /scan, Style: Points, Size (Pixels): 5, Queue Size: 10,
       Color Transformer: FlatColor, Color: 255; 0; 16, Alpha: 0.75, Decay Time: 3,
       Autocompute Value Bounds: {Max Value: 10, Min Value: -10, Value: true}}
    - {Class: rviz/PointCloud2, Enabled: true, Name: Cloud, Topic: points, Style: Flat Squares, Size (Pixels): 5,
       Color Transformer: AxisColor, Axis: Z}
    - Class: rviz/Group
      Enabled: false
      Name: Navigation
      Displays:
        - {Class: rviz/Map, Enabled: true, Name: Map, Topic: /map, Color Scheme: costmap, Alpha: 0.7}
        - {Class: rviz/Path, Enabled: true, Name: Plan, Topic: /plan, Color: 25; 255; 0}
    - {Class: rviz/Image, Enabled: true, Name: Image, Image Topic: /camera/image, Transport Hint: compressed}
    - {Class: rviz/Camera, Enabled: true, Name: Camera, Image Topic: /camera/image, Transport Hint: raw,
       Image Rendering: overlay, Overlay Alpha: 0.5, Zoom Factor: 2}
    - {Class: rviz/MarkerArray, Enabled: true, Name: Markers, Marker Topic: /markers,
       Namespaces: {walls: true, text: false}}
    - {Class: rviz/Odometry, Enabled: true, Name: Odometry, Topic: /odom, Keep: 20, Covariance: {Value: false},
       Shape: {Value: Axes, Color: 255; 25; 0}}
    - {Class: rviz/InteractiveMarkers, Enabled: true, Update Topic: /handles/update, Show Descriptions: false}
    - {Class: rviz/DepthCloud, Enabled: true, Depth Map Topic: /depth/image, Color Image Topic: /camera/image}
    - {Class: moveit_rviz_plugin/PlanningScene, Enabled: true, Name: Planning}
  Global Options: {Background Color: 48; 48; 48, Fixed Frame: odom}
  Tools:
    - {Class: rviz/Interact}
    - {Class: rviz/SetGoal, Topic: /goal}
    - {Class: my_tools/Plant}
  Views:
    Current: {Class: rviz/Orbit, Distance: 10, Pitch: 0.5, Yaw: 1.5, Target Frame: <Fixed Frame>,
              Focal Point: {X: 1, Y: 2, Z: 0}}
    Saved: ~
Window Geometry: {Height: 800}
"""
VIEW = "Visualization Manager: {Views: {Current: %s}}\nWindow Geometry: {Height: 800}"

PIECES = ["", "~", "[", "{", "}", ": ", "- ", "1e999", ".nan", "&a ", "*a", "\t", "é", "\x07"]
STRANGE = [None, True, -1, 1e300, math.nan, math.inf, "", "x" * 1000, [], [[]], {}, {1: 2}, "2020-01-01", {None: None}]


def resolve(name: str) -> str:
    return "/" + name.lstrip("/")


def read(text: str) -> RvizFile:
    return read_rviz(text, resolve)


def test_what_the_panel_shows() -> None:
    settings, notes = read(FILE)
    assert settings["fixed"] == "odom"
    assert settings["robots"] == ["/robot_description"]
    assert settings["tools"] == {"goal": "/goal"}
    assert settings["topics"] == [
        "/scan", "/points", "/map", "/plan", "/camera/image/compressed", "camera:/camera/image", "/markers", "/odom",
        "/handles/update", "depth:/depth/image",
    ]  # fmt: skip
    assert settings["hidden"] == ["/map", "/plan", "frames"]
    assert settings["options"] == {
        "grid": {"count": 10, "cell": 0.5, "flat": True, "tint": "#0080ff", "plane": "xy"},
        "robot:/robot_description": {"visual": False, "collision": True, "alpha": 0.5},
        "frames": {"names": False, "lines": True, "size": 0.4},
        "/scan": {"style": "pixels", "size": 5, "alpha": 0.75, "flat": True, "tint": "#ff0010", "decay": 3},
        "/points": {"style": "squares", "size": 5, "by": "z"},
        "/map": {"alpha": 0.7, "scheme": "costmap"},
        "/plan": {"tint": "#19ff00"},
        "camera:/camera/image": {"behind": False, "alpha": 0.5, "zoom": 2},
        "/markers": {"ns:walls": True, "ns:text": False},
        "/odom": {"axes": True, "tint": "#ff1900", "covariance": False, "keep": 20},
        "/handles/update": {"names": False},
        "depth:/depth/image": {"colour": "/camera/image"},
    }
    assert notes == [
        "PlanningScene 'Planning': unsupported display moveit_rviz_plugin/PlanningScene",
        "unsupported tool my_tools/Plant",
        "unsupported panel my_panels/Buttons",
    ]


def test_a_file_without_frames_and_grid_shows_none() -> None:
    settings, notes = read("Visualization Manager: {Displays: []}")
    assert settings == {"fixed": "", "topics": [], "robots": [], "options": {}, "hidden": ["frames", "grid"]}
    assert notes == []


def test_the_view_around_a_point() -> None:
    view = read(FILE).settings["view"]
    assert view["name"] == "orbit" and view["target"] == [1, 2, 0]
    eye = [1 + 10 * math.cos(1.5) * math.cos(0.5), 2 + 10 * math.sin(1.5) * math.cos(0.5), 10 * math.sin(0.5)]
    assert view["position"] == pytest.approx(eye, abs=1e-3)


def test_views_of_other_kinds() -> None:
    settings, notes = read(VIEW % "{Class: rviz/ThirdPersonFollower, Distance: 5, Target Frame: base_link}")
    assert settings["target"] == "base_link"
    assert settings["view"] == {"name": "third", "position": [5, 0, 0], "target": [0, 0, 0]}
    assert read(VIEW % "{Class: rviz/FPS, Position: {X: 1, Y: 0, Z: 2}, Pitch: 0, Yaw: 0}").settings["view"] == {
        "name": "walk",
        "position": [1, 0, 2],
        "target": [2, 0, 2],
    }
    flat = read(VIEW % "{Class: rviz/TopDownOrtho, X: 3, Y: 4, Scale: 100, Angle: 0}").settings["view"]
    assert flat == {"name": "flat", "position": [3, 3.95, 100], "target": [3, 4, 0], "zoom": 2.0}  # 8 m in 800 pixels
    assert read(VIEW % "{Class: rviz/FrameAligned}").settings["view"] == {"name": "frame"}
    assert notes == []
    settings, notes = read(VIEW % "{Class: views/Drone}")
    assert "view" not in settings
    assert notes == ["unsupported view views/Drone: the default view is used"]
    _, notes = read(VIEW % "{Class: rviz/Orbit, Target Frame: base, Focal Point: {X: 1, Y: 0, Z: 0}}")
    assert notes == ["the view looks at the origin of its frame, not at another point in it"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("", 'has no "Visualization Manager"'),
        ("[1, 2]", 'has no "Visualization Manager"'),
        ("Visualization Manager: 7", 'has no "Visualization Manager"'),
        ("Background\\ ColorR=0.1\nTarget\\ Frame=/base", "Visualization Manager"),  # rviz's form before 1.9
        ("Visualization Manager: {", "is not YAML: "),
        ("Visualization Manager: !!python/object/apply:os.system ['true']", "is not YAML: "),
        ("a: &a [&b [*a]]", "is not YAML: "),
        ("a: " + "[" * 5000, "is not YAML: "),
        ("\x00", "is not YAML: "),
        ("#" * (MAX_FILE_SIZE + 1), "is longer than "),
    ],
)
def test_files_that_are_not_rvizs(text: str, why: str) -> None:
    with pytest.raises(RvizFileError) as caught:
        read(text)
    assert why in str(caught.value) and "\n" not in str(caught.value)


def test_aliases_that_stand_for_more_than_fits_into_memory() -> None:
    bomb = "a: &a [x, x, x, x, x, x, x, x, x, x]\n"
    for old, new in zip("abcdefgh", "bcdefghi", strict=True):
        bomb += f"{new}: &{new} [{', '.join([f'*{old}'] * 10)}]\n"
    with pytest.raises(RvizFileError, match=r"is not YAML: .*aliases"):
        read(bomb + "Visualization Manager: {Displays: *i}")


def test_many_displays_and_notes_are_bounded() -> None:
    displays = ", ".join(f"{{Class: rviz/Path, Topic: /p{number}}}" for number in range(500))
    settings, notes = read(f"Visualization Manager: {{Displays: [{displays}]}}")
    assert len(settings["topics"]) == 200 and "more than 200 displays" in notes[0]
    displays = ", ".join(f"{{Class: my/Display{number}}}" for number in range(200))
    _, notes = read(f"Visualization Manager: {{Displays: [{displays}]}}")
    assert len(notes) == 41 and notes[-1] == "and 160 more that are not supported"


def test_names_cannot_write_to_the_terminal() -> None:
    text = yaml.safe_dump({"Visualization Manager": {"Displays": [{"Class": "a\x1b[2J\nb", "Name": "\x1b[31m"}]}})
    assert all(note.isprintable() for note in read(text).notes)


@pytest.mark.parametrize("seed", range(20))
def test_random_changes_give_settings_or_one_line(seed: int) -> None:
    chance = random.Random(seed)
    for _ in range(15):
        text = FILE
        for _ in range(chance.randrange(1, 6)):
            start = chance.randrange(len(text))
            end = start + chance.choice([0, 1, 2, 10, 80])
            text = text[:start] + chance.choice(PIECES) + text[end:]
        try:
            settings, notes = read(text)
        except RvizFileError as error:
            assert str(error).isprintable()
        else:
            json.dumps(settings, allow_nan=False)
            assert all(note.isprintable() for note in notes)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10))
def test_values_of_any_kind_in_any_place(seed: int) -> None:
    chance = random.Random(seed)

    def changed(value: object, deep: bool) -> object:
        if deep and chance.random() < 0.08:
            return chance.choice(STRANGE)
        if isinstance(value, dict):
            return {key: changed(each, True) for key, each in value.items()}
        return [changed(each, True) for each in value] if isinstance(value, list) else value

    data = yaml.safe_load(FILE)
    for _ in range(10):
        try:
            settings, notes = read(yaml.safe_dump(changed(data, False)))
        except RvizFileError as error:
            assert 'has no "Visualization Manager"' in str(error)
            continue
        json.dumps(settings, allow_nan=False)
        assert all(note.isprintable() for note in notes)
        assert all(len(key) < 300 for key in settings["topics"])


def test_frames_and_links_that_are_hidden_one_by_one_and_the_colour_behind_all() -> None:
    content = """
Visualization Manager:
  Global Options: {Background Color: 1; 2; 255}
  Displays:
    - {Class: rviz/TF, Frames: {All Enabled: false, a: {Value: false}, b: {Value: true}, 7: {Value: false}}}
    - {Class: rviz/RobotModel, Links: {All Links Enabled: true, arm: {Value: false}, base: {Value: true}}}
"""
    settings, notes = read_rviz(content, str)
    assert notes == []
    assert settings["background"] == "#0102ff"
    assert settings["options"]["frames"] == {"concealed": ["a"]}
    assert settings["options"]["robot:robot_description"] == {"concealed": ["arm"]}
