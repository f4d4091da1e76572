"""robot_state_publisher and joint_state_publisher beside stock's: the same robots, parameters and messages."""

from __future__ import annotations

import random
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from harness import STOCK_PYTHON, Master, Process, until

from pyros1.ground.timing import Time
from pyros1.msgs.sensor_msgs.msg import JointState
from pyros1.msgs.tf2_msgs.msg import TFMessage
from pyros1.node import Node

OWN_MASTER = True
MASTERS = ("ours",)  # stock's node and ours are compared, whatever the master

STATES = Path("/usr/lib/robot_state_publisher/robot_state_publisher")
JOINTS = Path("/usr/lib/joint_state_publisher/joint_state_publisher")

pytestmark = [
    pytest.mark.ours_only,
    pytest.mark.skipif(
        not (STATES.exists() and JOINTS.exists()),
        reason="ros-robot-state-publisher or joint-state-publisher is not installed; run interop/setup",
    ),
]

PROGRAMS = {
    "states": {"ours": [sys.executable, "-m", "pyros1.urdf.state_publisher"], "stock": [str(STATES)]},
    "joints": {
        "ours": [sys.executable, "-m", "pyros1.urdf.joint_publisher"],
        "stock": [STOCK_PYTHON, "-u", str(JOINTS)],
    },
}
MOVING = ("revolute", "continuous", "prismatic")


def random_robot(seed: int, count: int = 30) -> tuple[str, list[str]]:
    """Return a description with all types of joints, and the names of those that move."""
    chance = random.Random(seed)

    def numbers(size: float) -> str:
        return " ".join(f"{chance.uniform(-size, size):.6f}" for _ in range(3))

    lines = [f'<robot name="random{seed}"><link name="link0"/>']
    moving: list[str] = []
    for index in range(1, count):
        kind = chance.choice([*MOVING, *MOVING, "fixed", "floating", "planar"])
        parent = index - 1 if chance.random() < 0.7 else chance.randrange(index)
        lines += [
            f'<link name="link{index}"/><joint name="joint{index:03}" type="{kind}">',
            f'<parent link="link{parent}"/><child link="link{index}"/>',
        ]
        if chance.random() < 0.8:
            lines.append(f'<origin xyz="{numbers(2)}" rpy="{numbers(4)}"/>')
        if chance.random() < 0.8:
            lines.append(f'<axis xyz="{numbers(3)}"/>')
        if kind in ("revolute", "prismatic"):
            low = chance.uniform(-2, 1)
            lines.append(f'<limit lower="{low}" upper="{low + chance.uniform(0, 3)}" effort="1" velocity="1"/>')
            if chance.random() < 0.3:
                soft = f'soft_lower_limit="{low + 0.1}" soft_upper_limit="{low + 1}"'
                lines.append(f'<safety_controller {soft} k_velocity="1"/>')
        if kind in MOVING:
            # Stock finds the leader of a leader only if its name comes earlier.
            if moving and chance.random() < 0.2:
                number = f'multiplier="{chance.uniform(-2, 2):.3f}" offset="{chance.uniform(-1, 1):.3f}"'
                lines.append(f'<mimic joint="{chance.choice(moving)}" {number}/>')
            moving.append(f"joint{index:03}")
        lines.append("</joint>")
    return "\n".join([*lines, "</robot>"]), moving


class Both:
    """Stock's node and ours, and what they publish."""

    def __init__(self, launcher: Master, program: str, **params: Any) -> None:
        self.node = Node("both", anonymous=True, argv=[], environ=launcher.environ(), handle_signals=False)
        self.came: dict[str, list[Any]] = {"ours": [], "stock": []}
        self.fixed: dict[str, list[Any]] = {"ours": [], "stock": []}
        self.processes: dict[str, Process] = {}
        outputs: list[Any] = []
        for who, command in PROGRAMS[program].items():
            name = f"{program}_{who}"
            for key, value in {"rate": 20, **params}.items():
                self.node.params[f"/{name}/{key}"] = value
            words = [f"__name:={name}"]
            if program == "states":
                words += [f"/tf:=/{who}/tf", f"/tf_static:=/{who}/tf_static"]
                outputs.append(self.node.subscribe(f"/{who}/tf", TFMessage, self.came[who].append))
                self.node.subscribe(f"/{who}/tf_static", TFMessage, self.fixed[who].append)
            else:
                words += [f"joint_states:=/{who}/joint_states"]
                outputs.append(self.node.subscribe(f"/{who}/joint_states", JointState, self.came[who].append))
            self.processes[who] = launcher.run([*command, *words], python=who)
        self.publisher = self.node.advertise("/joint_states" if program == "states" else "/source", JointState)
        if program == "states" or "source_list" in params:
            assert self.publisher.wait_for_subscribers(2, timeout=20)
            assert all(output.wait_for_publishers(timeout=20) for output in outputs)  # or the first answers are lost

    def say(self, at: float, positions: dict[str, float], **more: Any) -> None:
        message = JointState(name=list(positions), position=list(positions.values()), **more)
        message.header.stamp = Time.from_sec(at)
        self.publisher.publish(message)


@pytest.fixture
def both(launcher: Master) -> Iterator[Callable[..., Both]]:
    """Return a function that starts both: the description, the program, and its parameters."""
    made: list[Both] = []

    def start(robot: str, program: str, **params: Any) -> Both:
        setter = Node("setter", anonymous=True, argv=[], environ=launcher.environ(), handle_signals=False)
        setter.params["/robot_description"] = robot
        for name in (f"/{program}_ours", f"/{program}_stock"):
            if name in setter.params:
                del setter.params[name]
        setter.shutdown()
        made.append(Both(launcher, program, **params))
        return made[-1]

    yield start
    for each in made:
        each.node.shutdown()


def transforms(messages: list[TFMessage]) -> dict[tuple[int, str], tuple[str, list[float]]]:
    """Return what was published: (time, child) -> parent and numbers."""
    found = {}
    for message in list(messages):
        for each in message.transforms:
            moved, turned = each.transform.translation, each.transform.rotation
            numbers = [moved.x, moved.y, moved.z, turned.x, turned.y, turned.z, turned.w]
            found[each.header.stamp.to_nsec(), each.child_frame_id] = (each.header.frame_id, numbers)
    return found


def assert_same(ours: dict[Any, tuple[str, list[float]]], stock: dict[Any, tuple[str, list[float]]]) -> None:
    assert ours.keys() == stock.keys()
    for key, (parent, numbers) in stock.items():
        assert ours[key][0] == parent
        mine = ours[key][1]
        if abs(abs(numbers[6]) - 0.5) < 1e-6 and mine[3] * numbers[3] < 0:
            mine = [*mine[:3], *(-part for part in mine[3:])]  # either sign will do there
        assert mine == pytest.approx(numbers, abs=1e-9), key


@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_random_robots(both: Callable[..., Both], seed: int) -> None:
    """Feature: robot_state_publisher: the same transforms as stock's, to 1e-9, on random robots with all joint
    types -- the same parameters, warnings and kinds of message
    """
    robot, joints = random_robot(seed)
    pair = both(robot, "states", ignore_timestamp=True)
    chance = random.Random(seed)
    for step in range(50):
        some = chance.sample(joints, chance.randint(1, len(joints)))
        pair.say(1000.0 + step, {name: chance.uniform(-7, 7) for name in [*some, "nobody"]})
        until(lambda step=step: all(len(came) > step for came in pair.came.values()), f"answers {step}")
    assert_same(transforms(pair.came["ours"]), transforms(pair.came["stock"]))
    until(lambda: all(pair.fixed.values()), "fixed links")
    fixed = {who: transforms(came) for who, came in pair.fixed.items()}
    timeless = {who: {child: value for (_, child), value in found.items()} for who, found in fixed.items()}
    assert_same(timeless["ours"], timeless["stock"])


def test_which_messages_count(both: Callable[..., Both]) -> None:
    robot, joints = random_robot(5)
    pair = both(robot, "states", publish_frequency=10, tf_prefix="one")
    chance = random.Random(5)
    at = 1000.0
    *some, marker = joints

    def say(at: float, positions: dict[str, float], end: int) -> None:
        """Publish a message, and then wait for one that always counts, stamped `end` (in s)."""
        pair.say(at, positions)
        time.sleep(0.03)
        pair.say(end, {marker: 0.5})
        until(
            lambda: all(
                came and came[-1].transforms and came[-1].transforms[0].header.stamp == Time(end)
                for came in pair.came.values()
            ),
            f"answer {end}",
        )

    def say_again(at: float, positions: dict[str, float]) -> bool:
        """Return whether the same messages have counted so far.

        Stock drops a message that arrives while it is busy. One that does not count, does not count again either.
        """
        nonlocal number
        number += 1
        say(at, positions, 5000 + number)
        return transforms(pair.came["ours"]).keys() == transforms(pair.came["stock"]).keys()

    number = 0
    for step in range(100):
        at += chance.uniform(-0.05, 0.12)
        positions = {name: chance.random() for name in chance.sample(some, 3)}
        until(lambda at=at, positions=positions: say_again(at, positions), f"answers {step}")
    ours, stock = transforms(pair.came["ours"]), transforms(pair.came["stock"])
    assert len(stock) > 200
    assert_same(ours, stock)


def test_fixed_links_on_tf(both: Callable[..., Both]) -> None:
    pair = both(random_robot(1)[0], "states", use_tf_static=False, publish_frequency=20)
    until(lambda: all(len(came) >= 5 for came in pair.came.values()), "fixed links again and again")
    links = {who: {child: value for (_, child), value in transforms(came).items()} for who, came in pair.came.items()}
    assert_same(links["ours"], links["stock"])
    assert not pair.fixed["ours"] and not pair.fixed["stock"]

    def in_time(came: list[TFMessage]) -> bool:
        """Whether the last ones are for half a second later, and 0.05 s apart."""
        now = pair.node.now().to_sec()
        found = [each.transforms[0].header.stamp.to_sec() for each in came[-4:]]
        return now < found[-1] < now + 0.6 and found[-1] - found[0] == pytest.approx(0.15, abs=0.1)

    for who, came in pair.came.items():  # at some moment, since a busy machine delays them now and then
        until(lambda came=came: in_time(came), f"{who} publishes in time")


def test_warnings_are_the_same(both: Callable[..., Both]) -> None:
    robot, joints = random_robot(1)
    pair = both(robot, "states")
    old = r"Received JointState is \d+\.\d+ seconds old\."
    unknown = 'Joint state with name: "nobody" was received but not found in URDF'
    invalid = "Robot state publisher ignored an invalid JointState message"
    bare = r'ignored a JointState message about joint\(s\) "a"\(,...\) whose position member was empty'
    for message, told in [
        (JointState(name=["nobody", joints[0]], position=[1.0, 1.0]), [old, unknown]),
        (JointState(name=["a", "b"], position=[1.0]), [invalid]),
        (JointState(name=["a", "b"]), [bare]),
    ]:
        message.header.stamp = Time(1)
        pair.publisher.publish(message)
        for process in pair.processes.values():
            for text in told:
                process.wait_line(text)


@pytest.mark.parametrize("robot", ["<robot>", '<robot name="x"><link name="a"/><link name="b"/></robot>'])
def test_robots_that_cannot_be(launcher: Master, robot: str) -> None:
    with Node("setter", anonymous=True, argv=[], environ=launcher.environ(), handle_signals=False) as setter:
        setter.params["/robot_description"] = robot
    for who, command in PROGRAMS["states"].items():
        process = launcher.run([*command, "__name:=wrong"], python=who)
        assert process.child.wait(20) != 0
        assert process.lines


JOINT_PARAMETERS: list[dict[str, Any]] = [
    {},
    {"use_mimic_tags": False, "use_smallest_joint_limits": False},
    {"publish_default_velocities": True, "publish_default_efforts": True},
    {"publish_default_positions": False},
    {"publish_default_positions": False, "use_mimic_tags": False},
]


@pytest.mark.parametrize("params", JOINT_PARAMETERS, ids=str)
@pytest.mark.parametrize("seed", [1, 2])
def test_joint_states(both: Callable[..., Both], params: dict[str, Any], seed: int) -> None:
    """Feature: joint_state_publisher: the same states as stock's -- all parameters, sources, mimic joints"""
    robot, joints = random_robot(seed)
    chance = random.Random(seed)
    free = [name for name in joints if f'name="{name}"' in robot][:4]
    params = {
        **params,
        "source_list": ["/source"],
        "zeros": {name: chance.uniform(-5, 5) for name in free[:2]},
        "dependent_joints": {free[3]: {"parent": free[0], "factor": -2.5, "offset": 0.5}},
    }
    pair = both(robot, "joints", **params)

    def last(who: str) -> tuple[list[str], list[float], list[float], list[float]]:
        it = pair.came[who][-1]
        return list(it.name), list(it.position), list(it.velocity), list(it.effort)

    def same() -> bool:
        if not all(pair.came.values()):
            return False
        (names, *ours), (wanted, *stock) = last("ours"), last("stock")
        close = [mine == pytest.approx(theirs, abs=1e-12) for mine, theirs in zip(ours, stock, strict=True)]
        return names == wanted and all(close)

    until(same, "the same at the start")
    before = last("ours")
    some = chance.sample(joints, 6)
    told = {name: chance.uniform(-5, 5) for name in some}
    pair.say(1.0, {**told, "nobody": 1.0}, velocity=[1.5] * 7, effort=[2.5] * 7)
    until(lambda: last("ours") != before and last("stock") != before, f"both changed: {some}")
    until(same, "the same with a source")
    assert last("ours")[3], "efforts came"
