"""Questions about a running system."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from pyros1.graph import Graph, names_in_namespace, parse_bus_entry, probe_service
from pyros1.ground.errors import MasterError, ProtocolError, ServiceUnavailableError
from pyros1.msgs.std_msgs.msg import String
from pyros1.msgs.std_srvs.srv import Empty, EmptyResponse
from pyros1.net.master_client import MasterClient


class FakeMaster:
    caller_id = "/test"

    def get_system_state(self) -> list[list[list[Any]]]:
        return [[["/a", ["/n1", "/n2"]], ["/a/b", ["/n2"]]], [["/a", ["/n3"]]], [["/s", ["/n1"]]]]

    def get_published_topics(self, subgraph: str = "") -> list[list[str]]:
        return [["/a", "x/Y"]]

    def get_topic_types(self) -> list[list[str]]:
        return [["/a", "x/Y"], ["/a/b", "x/Z"], ["/star", "*"]]

    def lookup_node(self, name: str) -> str:
        raise MasterError("unknown node")

    def lookup_service(self, service: str) -> str:
        raise MasterError("no provider")


def test_state_tells_nodes_and_what_each_registered() -> None:
    state = Graph(FakeMaster()).state()
    assert state.nodes() == ["/n1", "/n2", "/n3"]
    node = state.of_node("/n2")
    assert (node.publications, node.subscriptions, node.services) == (["/a", "/a/b"], [], [])


@pytest.mark.parametrize(
    ("name", "found"),
    [
        ("/a", ("/a", "x/Y", "")),
        ("/a/f[0]", ("/a", "x/Y", "/f[0]")),
        ("/a/b/c", ("/a/b", "x/Z", "/c")),
        ("/a[1]", ("/a", "x/Y", "[1]")),
        ("/ab", None),
        ("/star", None),
    ],
)
def test_a_name_is_split_at_the_longest_known_topic(name: str, found: object) -> None:
    """L60"""
    assert Graph(FakeMaster()).find_topic(name) == found


def test_unknown_node_and_service_are_none() -> None:
    graph = Graph(FakeMaster())
    assert graph.node_uri("/x") is None and graph.service_uri("/x") is None


def test_in_namespace() -> None:
    names = ["/a", "/a/b", "/ab", "/c"]
    assert names_in_namespace(names, "/a") == ["/a", "/a/b"]
    assert names_in_namespace(names, "/") == names_in_namespace(names, None) == names


def test_bus_entries_are_read_with_and_without_the_last_elements() -> None:
    """S03"""
    text = "TCPROS connection on port 5 to [1.2.3.4:7 on socket 9]"
    full = parse_bus_entry([1, "/x", "o", "TCPROS", "/t", 1, text])
    assert (full.connected, full.local_port, full.peer, full.socket) == (True, "5", "1.2.3.4:7", "9")
    short = parse_bus_entry([1, "/x", "i", "TCPROS", "/t"])
    assert (short.connected, short.peer) == (True, None)
    with pytest.raises(ProtocolError):
        parse_bus_entry([1, 2])


def test_a_live_node_and_service_are_asked(make_node: Callable[..., Any], environ: dict[str, str]) -> None:
    """S07, L79"""
    node = make_node("talker")
    node.advertise("t", String)
    node.advertise_service("s", Empty, lambda request: EmptyResponse())
    master = MasterClient("/test", environ["ROS_MASTER_URI"])
    graph = Graph(master)
    uri = graph.node_uri("/talker")
    assert uri == node.uri
    api = graph.node_api(uri)
    assert api.pid() > 0 and api.ping() >= 0 and isinstance(api.connections(), list)
    api.close()
    service_uri = graph.service_uri("/s")
    assert service_uri is not None
    assert probe_service("/s", service_uri, "/test")["type"] == "std_srvs/Empty"
    with pytest.raises(ServiceUnavailableError):
        probe_service("/other", service_uri, "/test")
    master.close()
