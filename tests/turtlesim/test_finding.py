"""Which turtles there are."""

from __future__ import annotations

from pyros1.turtlesim.finding import drawing_topic, find_simulators


def test_turtles_of_several_nodes() -> None:
    kinds = dict.fromkeys(["/turtle2/pose", "/turtle1/pose", "/left/turtle1/pose"], "turtlesim/Pose")
    kinds |= {"/turtle1/color_sensor": "turtlesim/Color", "/robot/pose": "geometry_msgs/Pose", "/x": "turtlesim/Pose"}
    publishers = {
        "/turtle1/pose": ["/sim"],
        "/turtle2/pose": ["/sim"],
        "/left/turtle1/pose": ["/left/sim"],
        "/x": ["/y"],
    }
    assert find_simulators(kinds, publishers) == {
        "/left/sim": {"turtle1": "/left/turtle1/pose"},
        "/sim": {"turtle1": "/turtle1/pose", "turtle2": "/turtle2/pose"},
    }
    assert drawing_topic("/left/sim") == "/left/sim/drawing"
    assert find_simulators({}, {}) == {}
