"""roswtf and ours on the same system of stock nodes (L178); ours names more, each with its cure.

Feature: `wtf` finds problems and says what to do -- each problem is provoked and found; the nodes it queries log
    nothing
"""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from harness import SOURCE, Master

OWN_MASTER = True

HEADINGS = (
    "No package or stack",
    "Package:",
    "=====",
    "Static checks summary:",
    "Beginning tests of your ROS graph",
    "analyzing graph...",
    "... done analyzing graph",
    "running graph rules...",
    "... done running graph rules",
    "Online checks summary:",
    "ROS Master does not appear",
    "Online graph checks",
    "ROS_MASTER_URI is",
)
KINDS = ["rospy", "roscpp"]


@pytest.fixture(scope="module")
def tool(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Our program under the stock tool's name."""
    tool = tmp_path_factory.mktemp("tools") / "roswtf"
    start = f"import sys; sys.path.insert(0, {str(SOURCE)!r}); from pyros1.cli.main import entry; sys.exit(entry())"
    tool.write_text(f"#!{sys.executable}\n{start}\n")
    tool.chmod(0o755)
    return tool


def ask(program: str | Path, master: Master, *words: str, folder: str = "/", **environ: str) -> tuple[int, str]:
    command = ["timeout", "-k", "2", "30", str(program), *words]
    env = {**master.environ(), **environ}
    done = subprocess.run(
        command, env=env, cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, timeout=60, check=False
    )
    return done.returncode, done.stdout.decode()


def headings(text: str) -> list[str]:
    return [line for line in text.splitlines() if line.startswith(HEADINGS)]


def findings(tool: Path, master: Master) -> dict[str, dict[str, Any]]:
    return {each["kind"]: each for each in json.loads(ask(tool, master, "--json")[1])}


def test_headings_and_exit_codes_l178(tool: Path, launcher: Master) -> None:
    """Online, offline and without a master, in a package and elsewhere; errors or not, stock returns 0."""
    nobody = "http://localhost:1"
    for words, folder, environ in (
        ((), "/", {}),
        (("--no-plugins",), "/usr/share/rospy", {}),
        ((), "/", {"ROS_MASTER_URI": nobody}),
        ((), "/", {"ROS_PACKAGE_PATH": "/usr/share:/nope"}),
        (("--bogus",), "/", {}),
    ):
        stock = ask("/usr/bin/roswtf", launcher, *words, folder=folder, **environ)
        ours = ask(tool, launcher, *words, folder=folder, **environ)
        assert ours[0] == stock[0]
        assert headings(ours[1]) == headings(stock[1])


@pytest.mark.parametrize("kind", KINDS)
def test_a_dead_node_is_named_by_both(tool: Path, launcher: Master, kind: str) -> None:
    victim = launcher.ready_peer(kind, f"wtf_victim_{kind}")
    victim.child.send_signal(signal.SIGKILL)
    victim.child.wait()
    stock, ours = ask("/usr/bin/roswtf", launcher), ask(tool, launcher)
    for text in (stock[1], ours[1]):
        assert "Could not contact the following nodes" in text and victim.name in text
    assert stock[0] == ours[0] == 0 and "pyros1 node cleanup" in ours[1]
    launcher.tool("rosnode", "cleanup", stdin="y\n")


@pytest.mark.parametrize("kind", KINDS)
def test_a_subscriber_of_another_type_is_found_and_goes_on(tool: Path, launcher: Master, kind: str, topic: str) -> None:
    publisher = launcher.ready_peer("roscpp", f"wtf_pub_{kind}")
    subscriber = launcher.ready_peer(kind, f"wtf_sub_{kind}")
    subscriber.tell("sub", topic, "std_msgs/Int64", 10)
    subscriber.event("subscribed", topic)
    publisher.tell("pub", topic, "std_msgs/String", 10, 0)
    publisher.event("advertised", topic)
    everything = findings(tool, launcher)
    assert "type-mismatch" in everything, json.dumps(everything, indent=1)
    ends = (publisher, subscriber)
    said = [list(end.lines) for end in ends]  # by now all that they say of each other
    findings(tool, launcher)
    assert [list(end.lines) for end in ends] == said, "whoever is asked logs nothing"
    found = everything["type-mismatch"]
    assert f"subscriber {subscriber.name}: std_msgs/Int64" in found["items"]
    assert f"publisher {publisher.name}: std_msgs/String" in found["items"]
    # A publisher of the right type is still heard.
    right = launcher.ready_peer("rospy", f"wtf_right_{kind}")
    right.tell("pub", topic, "std_msgs/Int64", 10, 1)
    right.event("advertised", topic)
    right.tell("send", topic, 1)
    subscriber.event("got", topic)


@pytest.mark.parametrize("kind", KINDS)
def test_a_healthy_link_is_left_alone(tool: Path, launcher: Master, kind: str, topic: str) -> None:
    publisher, subscriber = launcher.ready_peer("rospy", f"wtf_p_{kind}"), launcher.ready_peer(kind, f"wtf_s_{kind}")
    subscriber.tell("sub", topic, "std_msgs/String", 10)
    subscriber.event("subscribed", topic)
    publisher.tell("pub", topic, "std_msgs/String", 10, 0)
    publisher.event("advertised", topic)
    publisher.tell("linked", topic, 1)
    publisher.event("linked", topic)
    found = findings(tool, launcher)
    assert not {"missing-link", "unexpected-link", "type-mismatch", "md5-mismatch", "clock-skew"} & found.keys()
    publisher.tell("send", topic, 3)
    subscriber.event("got", topic)


def test_a_node_with_a_host_name_that_only_it_knows(tool: Path, launcher: Master) -> None:
    launcher.ready_peer("rospy", "wtf_lost", ROS_HOSTNAME="no-such-host.invalid")
    stock, found = ask("/usr/bin/roswtf", launcher)[1], findings(tool, launcher)
    assert "/wtf_lost" in stock
    assert found["unknown-host"]["items"] == ["/wtf_lost"] and "ROS_IP" in found["unknown-host"]["cure"]
