"""``rostopic list -b`` and ``echo -b`` against ours, on a bag of messages with and without a header (L27, L35, L36).

Feature: topics and messages in bags, as rostopic shows them -- `topic list -b`, `topic echo -b`
"""

from __future__ import annotations

import os
import random
import subprocess
import sys
from pathlib import Path

import pytest
from harness import SOURCE, stock_tools

import pyros1.bag
from pyros1.bag import BagWriter
from pyros1.ground.timing import Time
from pyros1.msgs import load_message

COMMANDS = """
list -b BAG
list -v -b BAG
list -b BAG /ns
list -b BAG /ns/state
list -p -b BAG
list -s -b BAG
list --host -b BAG
list -b nope.bag
list -h
echo -b BAG /word
echo -b BAG -n 1 /ns/state
echo -b BAG -n 2 /ns/state/position[0]
echo -b BAG -p /ns/state
echo -b BAG -p -n 2 /word/data
echo -b BAG -a -n 3
echo -b BAG -a -p -n 1
echo -b BAG -c -n 1 /word
echo -b BAG --noarr -n 1 /ns/state
echo -b nope.bag /word
echo -b BAG
echo -a /word
echo --offset -b BAG /word
""".strip().split("\n")


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("bags") / "some.bag"
    text, joints = load_message("std_msgs/String"), load_message("sensor_msgs/JointState")
    with BagWriter(path) as writer:
        connections = [
            writer.add_connection(
                topic,
                {
                    "type": cls._type.encode(),
                    "md5sum": cls._md5sum.encode(),
                    "message_definition": cls._full_text.encode(),
                    "callerid": b"/talker",
                },
            )
            for topic, cls in (("/ns/state", joints), ("/word", text))
        ]
        for number in range(5):
            state = joints(name=["a"], position=[float(number), 0.5])
            state.header.seq, state.header.stamp = number, Time(1000 + number, 7)
            moment = 1_600_000_000_000_000_000 + number * 1_000_000_000
            writer.write(connections[0], moment, joints._encode(state))
            writer.write(connections[1], moment + 1, text._encode(text(f"word {number}")))
    return path


NAMES = ["chatter", "/chatter", "ns/x", "/ns/x", "/a/b", "a", "numbers", "robot/chatter", "/robot/a"]
"""Topics as bags have them: roslaunch's namespaces, and recorders that others wrote, leave the slash out."""
MESSAGES = 30


@pytest.fixture(scope="module")
def names(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A bag whose topics have names of all forms."""
    rng = random.Random(28)
    text = load_message("std_msgs/String")
    path = tmp_path_factory.mktemp("names") / "names.bag"
    with pyros1.bag.open(path, "w") as bag:
        for number in range(MESSAGES):
            topic = NAMES[number] if number < len(NAMES) else rng.choice(NAMES)
            bag.write(topic, text(f"{topic} {number}"), Time(1000 + number))
    return path


def ask(command: list[str], words: list[str]) -> tuple[int, str, str]:
    if command == ["/usr/bin/rostopic"]:
        return stock_tools().ask([*command, *words], os.environ)
    done = subprocess.run([*command, *words], capture_output=True, timeout=60, check=False, stdin=subprocess.DEVNULL)
    return done.returncode, done.stdout.decode(), done.stderr.decode()


@pytest.mark.parametrize("line", COMMANDS)
def test_output_is_stocks(bag: Path, line: str) -> None:
    words = line.replace("BAG", str(bag)).split(" ")
    start = (
        f"import sys; sys.path.insert(0, {str(SOURCE)!r}); sys.argv[0] = 'rostopic'; "
        "from pyros1.cli.main import entry; sys.exit(entry())"
    )
    assert ask([sys.executable, "-c", start], words) == ask(["/usr/bin/rostopic"], words)


@pytest.mark.parametrize("namespace", ["", "/robot", "ns/"])
def test_topics_are_found_by_the_names_they_are_resolved_to(names: Path, namespace: str) -> None:
    start = [sys.executable, "-m", "pyros1", "topic"]
    asked = sorted({*NAMES, *(name.lstrip("/") for name in NAMES), *(f"/{name.lstrip('/')}" for name in NAMES)})
    asked += ["chatter/data", "/chatter/data", "/robot/chatter/", "/ns/x/data"]
    for name in asked:
        words = ["echo", "-b", str(names), name]
        environ = {**os.environ, "ROS_NAMESPACE": namespace}
        stock = stock_tools().ask(["/usr/bin/rostopic", *words], environ)
        ours = subprocess.run([*start, *words], capture_output=True, text=True, check=False, env=environ)
        assert (ours.returncode, ours.stdout) == stock[:2], (name, namespace)
        assert bool(ours.stderr) == (not ours.stdout), (name, namespace, ours.stderr)


def test_messages_below_a_namespace_are_counted_whatever_the_form_of_their_names(names: Path) -> None:
    """Stock's list finds only topics with a slash in front, and ends with a traceback if there are none."""
    start = [sys.executable, "-m", "pyros1", "topic", "list", "-b", str(names)]
    assert ask(start, ["/"])[1].startswith(f"{MESSAGES} message(s)")
    with pyros1.bag.open(names) as bag:
        both = bag.count(["chatter", "/chatter"])
    assert ask(start, ["/chatter"]) == ask(start, ["chatter"])
    assert ask(start, ["/chatter"])[1].startswith(f"{both} message(s)")


def test_a_topic_that_is_not_in_the_bag(bag: Path) -> None:
    """Stock says nothing, or ends with a traceback for `list`."""
    start = [sys.executable, "-m", "pyros1", "topic"]
    code, out, err = ask(start, ["echo", "-b", str(bag), "/wrod"])
    assert (code, out) == (0, "") and "did you mean '/word'?" in err
    code, out, err = ask(start, ["list", "-b", str(bag), "/wrod"])
    assert (code, out) == (1, "") and "Traceback" not in err and "no messages on /wrod" in err
