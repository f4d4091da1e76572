"""Sites that run in the test's process: a master, a bridge, and nodes, with eclipse-zenoh between them."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from pyros1.bridge.rules.parsing import parse_config
from pyros1.bridge.transport.link import Link, Receive
from pyros1.master.server import Master
from pyros1.node import Node
from pyros1.node.publishing.publisher import Publisher

PATIENCE = 20.0


def wait_until(holds: Callable[[], object], what: str) -> None:
    """Wait until something holds; fail if it never does."""
    deadline = time.monotonic() + PATIENCE
    pause = threading.Event()
    while not holds():
        assert time.monotonic() < deadline, f"never: {what}"
        pause.wait(0.02)


def subscriptions(publisher: Publisher[Any]) -> int:
    """Return the number of subscribers in the test's process. A bridge's question for a topic's type does not count:
    it is another connection, which its publisher may take for a subscriber until it notices that it was closed.
    """
    return sum(link.transport == "INTRAPROCESS" for link in publisher.links)


def wait_for_subscribers(publisher: Publisher[Any], count: int = 1) -> None:
    """Wait until there are so many subscribers, see `subscriptions`."""
    wait_until(lambda: subscriptions(publisher) >= count, f"{count} subscribe to {publisher.name}")


class QueuedSubscriber:
    """A subscriber whose messages can be waited for."""

    def __init__(self, node: Node, topic: str, type_name: str = "std_msgs/String") -> None:
        self._queue: queue.Queue[Any] = queue.Queue()
        self.subscriber = node.subscribe(topic, type_name, self._queue.put)

    def get(self) -> Any:
        """Return the next message."""
        return self._queue.get(timeout=PATIENCE)

    def receives(self, data: str) -> None:
        """Wait for this text; others may come before."""
        while self.get().data != data:
            pass

    def is_silent(self) -> bool:
        """Return whether no message waits."""
        return self._queue.empty()


class RunningSite:
    """A master with a bridge, and a node for the test."""

    def __init__(self, name: str, rules: str, folder: Path, make_link: Callable[[Receive], Link]) -> None:
        from pyros1.bridge.runner import Bridge

        self.name = name
        self.master = Master(port=0, bind_host="127.0.0.1")
        self.master.start()
        self.environ = {"ROS_MASTER_URI": self.master.uri, "ROS_HOSTNAME": "localhost", "ROS_HOME": str(folder / name)}
        self._nodes: list[Node] = []
        self.rules = parse_config(rules, "rules.yaml", name).rules
        self._make_link = make_link
        self.node = self.make_node("user")
        self.bridge_node = self.make_node(f"bridge_{name}")
        self.bridge = Bridge(self.bridge_node, self.rules, make_link)

    def make_node(self, name: str) -> Node:
        """Return a new node of this site's master."""
        node = Node(name, argv=[], environ=self.environ, handle_signals=False)
        self._nodes.append(node)
        return node

    def restart_bridge(self) -> None:
        """End the bridge, and start another one."""
        from pyros1.bridge.runner import Bridge

        self.bridge_node.shutdown()
        self.bridge_node = self.make_node(f"bridge_{self.name}")
        self.bridge = Bridge(self.bridge_node, self.rules, self._make_link)

    def topics(self) -> dict[str, str]:
        """Return the types of the topics that somebody publishes, by name."""
        return dict(self.node.master.get_published_topics())

    def has_topic(self, topic: str) -> None:
        """Wait until somebody publishes a topic."""
        wait_until(lambda: topic in self.topics(), f"{topic} at {self.name}")

    def close(self) -> None:
        """End everything."""
        for node in reversed(self._nodes):
            node.shutdown()
        self.master.stop()


@pytest.fixture
def make_site(tmp_path: Path) -> Iterator[Callable[..., RunningSite]]:
    """Return a function that starts a site: name, rules as YAML, endpoints to connect to and to listen on."""
    pytest.importorskip("zenoh")
    from pyros1.bridge.transport.zenoh_link import ZenohLink

    sites: list[RunningSite] = []

    def make(name: str, rules: str, connect: tuple[str, ...] = (), listen: tuple[str, ...] = ()) -> RunningSite:
        sites.append(RunningSite(name, rules, tmp_path, lambda receive: ZenohLink(name, receive, connect, listen)))
        return sites[-1]

    yield make
    # Those that only dial first: a router that closes before its clients can hang.
    for site in reversed(sites):
        site.close()


@pytest.fixture
def endpoint(free_port: int) -> str:
    """An endpoint that nobody uses."""
    return f"tcp/127.0.0.1:{free_port}"
