"""Curves on the command line."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.shared.curves import expand_messages, parse_curves


def invocation(environ: dict[str, str]) -> Invocation:
    return Invocation("web", "", [], with_verb=False, environ=environ)


@pytest.mark.parametrize("word", [":x", "x:y", "x:", "/a/x,y:z"])
def test_fields_without_a_topic(word: str) -> None:
    with pytest.raises(UsageError, match="must contain a topic and a field"):
        parse_curves(invocation({}), word)


@pytest.mark.parametrize(
    "word", ["/a/x:y", "a/x:y", "/a/x[0]:y[0]", "/a/x:", "/a: m.x * 2", "a: [m.x, m.y]", "/a,/b/x:y"]
)
def test_fields_with_a_topic(word: str) -> None:
    assert parse_curves(invocation({}), word)


@pytest.mark.parametrize(
    ("curve", "expected"),
    [
        (
            "/turtle1/pose",
            [f"/turtle1/pose/{name}" for name in ("x", "y", "theta", "linear_velocity", "angular_velocity")],
        ),
        (
            "/turtle1/pose/",
            [f"/turtle1/pose/{name}" for name in ("x", "y", "theta", "linear_velocity", "angular_velocity")],
        ),
        ("/turtle1/pose/x", ["/turtle1/pose/x"]),
        ("/odom/pose/pose/position", [f"/odom/pose/pose/position/{axis}" for axis in "xyz"]),
        ("/odom/header", ["/odom/header/seq"]),
        ("/odom", ["/odom"]),  # no number of its own
        ("/odom/pose/covariance", ["/odom/pose/covariance"]),
        ("/odom/nothing", ["/odom/nothing"]),
        ("/odom/pose[", ["/odom/pose["]),
        ("/force", ["/force"]),
        ("/unknown", ["/unknown"]),
        ("/odom: m.pose", ["/odom: m.pose"]),
    ],
)
def test_messages_are_the_curves_of_their_numbers(
    environ: dict[str, str], make_node: Callable[..., Any], curve: str, expected: list[str]
) -> None:
    node = make_node("one")
    node.advertise("/turtle1/pose", "turtlesim/Pose")
    node.advertise("/odom", "nav_msgs/Odometry")
    node.advertise("/force", "std_msgs/Float64")
    asked = invocation(environ)
    assert expand_messages(asked, [curve, "/force"]) == [*expected, "/force"]
    asked.close()


def test_curves_without_a_master(closed_port: int) -> None:
    asked = invocation({"ROS_MASTER_URI": f"http://127.0.0.1:{closed_port}"})
    assert expand_messages(asked, ["/odom/pose/pose/position"]) == ["/odom/pose/pose/position"]
    asked.close()
