"""Whoever depends on a node of another site is told when it is gone, whatever has taken it away.

Feature: the death of a node is noticed at other sites, by `node.watch` and by lost connections -- `pyros1 bridge`
"""

from __future__ import annotations

import os
import queue
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from xmlrpc.client import ServerProxy

import pytest

from pyros1.node.watching.liveness import Sighting

from .conftest import QueuedSubscriber, RunningSite, wait_until
from .test_running import kill, start_router

MakeSite = Callable[..., RunningSite]
EVERYTHING = "{send: ['/**'], take: ['*:**', '/**'], loss: 1.5}"
TALKER = """
import sys
import pyros1
with pyros1.Node("talker", argv=[]) as node:
    publisher = node.advertise("/text", "std_msgs/String", latch=True)
    publisher.publish("latched")
    print("ready", flush=True)
    sys.stdin.read()
"""
BRIDGE = ("-m", "pyros1", "bridge", "--site", "red", "--send", "/text", "--loss", "1.5", "--to")


@contextmanager
def running(site: RunningSite, *args: str) -> Iterator[subprocess.Popen[str]]:
    """Run a program with the master of a site."""
    with subprocess.Popen(
        [sys.executable, *args],
        env={**os.environ, **site.environ},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as program:
        try:
            yield program
        finally:
            program.kill()


@contextmanager
def talker(site: RunningSite) -> Iterator[subprocess.Popen[str]]:
    """Run a node that publishes /text."""
    with running(site, "-c", TALKER) as program:
        assert program.stdout is not None and program.stdout.readline() == "ready\n"
        yield program


class Listener:
    """A node at the base that depends on the talker at red."""

    def __init__(self, site: RunningSite, topic: str = "/red/text", name: str = "/red/talker") -> None:
        self.site = site
        site.has_topic(topic)
        self.messages = QueuedSubscriber(site.node, topic)
        self.sightings: queue.Queue[Sighting] = queue.Queue()
        self.watch: Any = site.node.watch(name, self.sightings.put, self.sightings.put)
        self.topic = topic

    def sees(self, alive: bool) -> None:
        """Wait until the talker is found or lost."""
        assert self.sightings.get(timeout=20).alive is alive

    def sees_loss(self) -> None:
        """Wait until the talker is lost, and with it the publisher of its topic."""
        self.sees(False)
        subscriber: Any = self.messages.subscriber
        wait_until(lambda: subscriber.num_connections == 0, "the connection is lost")
        wait_until(lambda: self.topic not in self.site.topics(), "the topic is withdrawn")

    def sees_return(self) -> None:
        """Wait until the talker is found again, and its latched message comes again."""
        self.sees(True)
        self.messages.receives("latched")


@pytest.fixture
def pair(make_site: MakeSite, endpoint: str) -> tuple[RunningSite, RunningSite]:
    base = make_site("base", EVERYTHING, (), (endpoint,))
    return make_site("red", EVERYTHING, (endpoint,)), base


@pytest.mark.slow
def test_a_node_is_killed_and_returns(pair: tuple[RunningSite, RunningSite]) -> None:
    red, base = pair
    with talker(red) as program:
        listener = Listener(base)
        listener.sees_return()
        program.kill()
        listener.sees_loss()
        assert "/text" in red.topics(), "a master does not notice it"
    with talker(red):
        listener.sees_return()
        assert listener.messages.is_silent()


@pytest.mark.slow
def test_a_node_hangs_and_goes_on(pair: tuple[RunningSite, RunningSite]) -> None:
    red, base = pair
    with talker(red) as program:
        listener = Listener(base)
        listener.sees_return()
        program.send_signal(signal.SIGSTOP)
        listener.sees_loss()
        program.send_signal(signal.SIGCONT)
        listener.sees_return()


@pytest.mark.slow
def test_one_of_two_publishers_is_killed(pair: tuple[RunningSite, RunningSite]) -> None:
    red, base = pair
    other: Any = red.make_node("other").advertise("/text", "std_msgs/String", latch=True)
    with talker(red) as program:
        listener = Listener(base)
        listener.sees_return()
        program.kill()
        listener.sees(False)
        other.publish("from the other")
        listener.messages.receives("from the other")
        subscriber: Any = listener.messages.subscriber
        assert subscriber.num_connections == 1


@pytest.mark.slow
def test_a_bridge_is_killed_and_returns(make_site: MakeSite, endpoint: str) -> None:
    base = make_site("base", EVERYTHING, (), (endpoint,))
    red = make_site("red", "{}", (endpoint,))
    red.bridge_node.shutdown()
    with talker(red):
        with running(red, *BRIDGE, endpoint) as bridge:
            listener = Listener(base)
            listener.sees_return()
            bridge.kill()
            listener.sees_loss()
        with running(red, *BRIDGE, endpoint):
            listener.sees_return()


@pytest.mark.slow
def test_a_network_is_parted_and_mended(make_site: MakeSite, endpoint: str) -> None:
    router = start_router(endpoint)
    try:
        base, red = make_site("base", EVERYTHING, (endpoint,)), make_site("red", EVERYTHING, (endpoint,))
        with talker(red):
            listener = Listener(base)
            listener.sees_return()
            router.send_signal(signal.SIGSTOP)  # no connection is closed, but nothing arrives
            listener.sees_loss()
            router.send_signal(signal.SIGCONT)
            listener.sees_return()
            assert listener.messages.is_silent()
    finally:
        kill(router)


@pytest.mark.slow
def test_the_site_says_goodbye(pair: tuple[RunningSite, RunningSite]) -> None:
    red, base = pair
    with talker(red):
        listener = Listener(base)
        listener.sees_return()
        red.bridge_node.shutdown()
        listener.sees_loss()
        red.restart_bridge()
        listener.sees_return()


@pytest.mark.slow
def test_a_command_at_the_death_of_a_node_reaches_the_other_site(
    make_site: MakeSite, endpoint: str, tmp_path: Path
) -> None:
    """Feature: `on-death` of a launch file halts robots of other sites -- `pyros1 bridge`"""
    base = make_site("base", "take: ['red:**']", (), (endpoint,))
    red = make_site("red", "send: ['/**']", (endpoint,))
    launch = tmp_path / "robot.launch"
    command = "pub /halt std_msgs/String now"
    launch.write_text(
        f'''<launch><node pkg="minimal_nodes" type="minimal_publisher" name="driver" on-death="{command}"/></launch>'''
    )
    commands = QueuedSubscriber(base.node, "/red/halt")
    with running(red, "-m", "pyros1", "launch", str(launch)):
        wait_until(lambda: "/topic1" in red.topics(), "the driver runs")
        with ServerProxy(red.node.master.lookup_node("/driver")) as driver:
            _, _, pid = driver.getPid("/test")
        assert isinstance(pid, int)
        os.kill(pid, signal.SIGKILL)
        commands.receives("now")
