"""The joints of a robot, and what moves them."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from queue import Queue
from typing import Any

import pytest

from pyros1.msgs.sensor_msgs.msg import JointState
from pyros1.node import Node
from pyros1.urdf import joint_publisher
from pyros1.web.server.wire import RequestError

PATIENCE = 20.0
Make = Callable[..., Any]
ARM = """
<robot name="arm"><link name="base"/><link name="arm"/>
<joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><limit lower="-1" upper="2"/></joint></robot>
"""


@pytest.fixture
def publisher(make_node: Make) -> Iterator[Node]:
    """A node that publishes the joints of ARM."""
    node: Node = make_node("joints")
    node.params["/robot_description"] = ARM
    node.params["~zeros"] = {"turn": 0.5}
    node.params["~rate"] = 50
    running = threading.Thread(target=joint_publisher.make_publisher(node).run)
    running.start()
    yield node
    node.shutdown()
    running.join(PATIENCE)


def last(watched: Any, key: str, fits: Callable[[Any], bool]) -> Any:
    return watched.until(lambda data: key in data and fits(data[key]))[key]


def test_a_node_that_takes_positions(publisher: Node, watch: Make) -> None:
    watched = watch("joints")
    facts = last(watched, "facts", lambda facts: facts["movable"])
    assert facts["joints"] == [{"name": "turn", "type": "revolute", "lower": -1.0, "upper": 2.0, "zero": 0.5}]
    assert (facts["publishers"], facts["topic"], facts["publishing"]) == (["/joints"], "/joint_states", False)
    watched.view.change({"positions": {"turn": 1.25, "nobody": 3}})
    last(watched, "positions", lambda positions: positions == [1.25])
    watched.view.change({"publish": True, "positions": {"turn": -0.5}})  # the node stays the one that publishes
    last(watched, "positions", lambda positions: positions == [-0.5])


def test_publishing_from_here_ends_when_the_robot_comes(make_node: Make, watch: Make) -> None:
    user = make_node("user")
    user.params["/robot_description"] = ARM
    came: Queue[Any] = Queue()
    user.subscribe("/joint_states", JointState, came.put)
    watched = watch("joints")
    facts = last(watched, "facts", lambda facts: facts["there"])
    assert not facts["movable"]
    with pytest.raises(RequestError, match="no node subscribes to"):
        watched.view.change({"positions": {"turn": 1.0}})
    watched.view.change({"publish": True, "positions": {"turn": 1.5}})
    assert last(watched, "facts", lambda facts: facts["publishing"])["movable"]
    while (message := came.get(timeout=PATIENCE)).position != (1.5,):
        pass
    assert message.header.stamp.to_sec() > 0
    driver = make_node("driver")
    driver.advertise("/joint_states", JointState)
    facts = last(watched, "facts", lambda facts: facts["publishers"] == ["/driver"])
    assert not facts["publishing"] and not facts["movable"]


@pytest.mark.slow
def test_of_two_pages_one_publishes(make_node: Make, watch: Make) -> None:
    user = make_node("user")
    user.params["/robot_description"] = ARM
    one, two = watch("joints"), watch("joints")
    for each in (one, two):
        last(each, "facts", lambda facts: facts["there"] and not facts["publishers"])
    one.view.change({"publish": True, "positions": {"turn": 1.5}})
    with pytest.raises(RequestError, match="another page is already publishing /joint_states"):
        two.view.change({"publish": True, "positions": {"turn": -1.0}})
    facts = last(two, "facts", lambda facts: facts["publishers"] == ["/web"])
    assert not facts["publishing"] and not facts["movable"]
    with pytest.raises(RequestError, match="another page is already publishing /joint_states"):
        two.view.change({"publish": True, "positions": {"turn": -1.0}})
    two.view.change({"publish": False})  # which ends nothing of the first page
    assert last(two, "positions", lambda positions: positions == [1.5])
    one.view.close()
    last(two, "facts", lambda facts: not facts["publishers"])
    two.view.change({"publish": True, "positions": {"turn": -1.0}})
    last(two, "positions", lambda positions: positions == [-1.0])


def test_a_page_that_comes_back_publishes_again(make_node: Make, watch: Make) -> None:
    """Its former connection may not be known to be dead yet."""
    make_node("user").params["/robot_description"] = ARM
    before = watch("joints", publish=True, positions={"turn": 1.5})
    last(before, "facts", lambda facts: facts["publishing"])
    again = watch("joints", publish=True, positions={"turn": 0.5})
    other = watch("joints", publish=True, positions={"turn": -0.5})
    last(again, "facts", lambda facts: facts["there"] and not facts["publishing"])
    other.view.change({"publish": False})  # it waits no longer
    before.view.close()
    last(again, "facts", lambda facts: facts["publishing"])
    last(again, "positions", lambda positions: positions == [0.5])
    assert not last(other, "facts", lambda facts: facts["publishers"] == ["/web"])["publishing"]


def test_what_is_wrong_with_a_description(make_node: Make, watch: Make) -> None:
    node = make_node("user")
    node.params["/left/robot_description"] = ARM
    watched = watch("joints")
    facts = last(watched, "facts", lambda facts: not facts["there"])
    assert facts["descriptions"] == ["/left/robot_description"] and facts["joints"] == []
    node.params["/robot_description"] = "<robot/>"
    with pytest.raises(RequestError, match="/robot_description: the robot has no links"):
        watched.until(lambda data: False)
    other = watch("joints", description="/left/robot_description")
    assert last(other, "facts", lambda facts: facts["there"])["topic"] == "/left/joint_states"


def test_what_pages_may_not_do(make_robot: Make, make_node: Make, watch: Make) -> None:
    make_node("user").params["/robot_description"] = ARM
    looking = make_robot(read_only=True)
    watched = watch("joints", looking)
    for args in ({"publish": True}, {"positions": {"turn": 1.0}}):
        with pytest.raises(RequestError, match="read-only"):
            watched.view.change(args)
        with pytest.raises(RequestError, match="read-only"):
            watch("joints", looking, **args)
    with pytest.raises(RequestError, match="this server does not show"):
        watch("joints", make_robot(topics=("/camera/*",)))
    with pytest.raises(RequestError, match="object"):
        watched.view.change({"positions": [1]})
