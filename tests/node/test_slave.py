"""slave: the API that master and tools call on a node (S01-S13)."""

from __future__ import annotations

import os
import threading
from typing import Any

import pytest

from pyros1.ground.errors import XmlRpcFault
from pyros1.msgs.std_msgs.msg import Float64
from pyros1.net.master_client import MasterClient
from pyros1.node import slave
from pyros1.node.log.levels import DEBUG

from ..bodies import encode_frame
from ..parts import context_of, subscription_of, tcpros_port


@pytest.fixture
def node(make_node: Any) -> Any:
    return make_node("talker", rosout=False)


def test_who_are_you_s04_s05_s07(node: Any, call_node: Any) -> None:
    assert call_node(node, "getPid", "/me") == [1, "", os.getpid()]
    assert call_node(node, "getName", "/me")[::2] == [1, "/talker"]
    assert call_node(node, "getUri", "/me") == [1, node.uri, node.uri]
    assert call_node(node, "getMasterUri", "/me") == [1, node.master_uri, node.master_uri]
    assert node.master.lookup_node("/talker") if node.advertise("t", Float64) else False


def test_topics_s08(node: Any, call_node: Any) -> None:
    assert call_node(node, "getPublications", "/me") == [1, "publications", []]
    node.advertise("a", Float64)
    node.subscribe("b", Float64, print)
    assert call_node(node, "getPublications", "/me") == [1, "publications", [["/a", "std_msgs/Float64"]]]
    assert call_node(node, "getSubscriptions", "/me") == [1, "subscriptions", [["/b", "std_msgs/Float64"]]]


def test_request_topic_s11(node: Any, call_node: Any) -> None:
    node.advertise("t", Float64)
    port = tcpros_port(node)
    ready = [1, f"ready on localhost:{port}", ["TCPROS", "localhost", port]]
    assert call_node(node, "requestTopic", "/me", "/t", [["TCPROS"]]) == ready
    assert call_node(node, "requestTopic", "/me", "/t", [["UDPROS", "", "h", 1, 1500], ["TCPROS"]]) == ready
    assert call_node(node, "requestTopic", "/me", "/x", [["TCPROS"]]) == [-1, "Not a publisher of [/x]", []]
    unsupported = [0, "no supported protocol implementations", []]
    assert call_node(node, "requestTopic", "/me", "/t", [["UDPROS"]]) == unsupported
    assert call_node(node, "requestTopic", "/me", "/t", [[], "TCPROS", 5]) == unsupported
    for invalid in ([], "TCPROS", 5):
        assert call_node(node, "requestTopic", "/me", "/t", invalid)[0] == -1
    assert call_node(node, "requestTopic", "/me", 5, [["TCPROS"]])[0] == -1


def test_publisher_update_s10(node: Any, call_node: Any) -> None:
    assert call_node(node, "publisherUpdate", "/master", "/t", []) == [1, "", 0]
    assert call_node(node, "publisherUpdate", "/master", "/t", ["http://localhost:1/"]) == [1, "", 0]
    node.subscribe("t", Float64, print)
    assert call_node(node, "publisherUpdate", "/master", "/t", ["http://localhost:1/"]) == [1, "", 0]
    assert call_node(node, "publisherUpdate", "/master", "/t", []) == [1, "", 0], "an empty list is no error (O04)"
    for invalid in ("http://localhost:1/", [5], ["no uri"], [""], ["rosrpc://localhost:1"], 7):
        code, text, _ = call_node(node, "publisherUpdate", "/master", "/t", invalid)
        assert code == -1 and "publishers" in text
    assert call_node(node, "publisherUpdate", "/master", 5, [])[0] == -1


def test_a_publisher_with_a_wrong_address_hides_no_other(
    make_node: Any, fake_node: Any, call_node: Any, collect: Any
) -> None:
    """Anybody can register such an address, also with a stock master."""
    fake, listener, got = fake_node("/fake"), make_node("listener"), collect()
    listener.subscribe("t", Float64, got)
    fake.answers["requestTopic"] = [1, "ready", ["TCPROS", "localhost", fake.port]]
    uris = ["http://a b:1/", fake.uri, "http://localhost:99999/"]
    code, text, _ = call_node(listener, "publisherUpdate", "/master", "/t", uris)
    assert code == -1 and "99999" in text
    fake.accept_subscriber().sendall(encode_frame(Float64(3.0)))
    assert got.wait(1)[0].data == 3.0


def test_publishers_that_are_known_are_not_looked_at_again(
    node: Any, call_node: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each new one of a thousand comes with a list of all: /rosout has them."""
    node.subscribe("t", Float64, print)
    uris = [f"http://localhost:{number}/" for number in range(1, 5)]
    looked_at: list[str] = []
    parse = slave.parse_uri
    monkeypatch.setattr(slave, "parse_uri", lambda uri: (looked_at.append(uri), parse(uri)))
    for count in range(1, 5):
        assert call_node(node, "publisherUpdate", "/master", "/t", uris[:count]) == [1, "", 0]
    assert looked_at == uris
    assert call_node(node, "publisherUpdate", "/master", "/t", []) == [1, "", 0]


def test_a_long_list_of_publishers_is_not_searched_for_each_of_them(node: Any) -> None:
    class List(list[str]):
        def __contains__(self, item: object) -> bool:
            raise AssertionError("the list was searched")

    node.subscribe("t", Float64, print)
    subscription = subscription_of(node)
    run = context_of(node).loop.run
    run(subscription.update_publishers, List(["http://localhost:1/"]))
    assert run(subscription.has_publisher, "http://localhost:1/")
    run(subscription.update_publishers, List())
    assert not run(subscription.has_publisher, "http://localhost:1/")


def test_an_update_that_overtakes_the_reply_to_a_registration_counts(
    node: Any, call_node: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The reply is older: a publisher that it does not list yet is kept."""
    newer = "http://localhost:1/"
    multicall = MasterClient.multicall
    overtaken: list[Any] = []

    def slow(client: MasterClient, calls: Any, **options: Any) -> list[Any]:
        replies = multicall(client, calls, **options)
        if any(call[0] == "registerSubscriber" for call in calls):
            overtaken.append(call_node(node, "publisherUpdate", "/master", "/u", [newer]))
        return replies

    monkeypatch.setattr(MasterClient, "multicall", slow)
    node.subscribe("u", Float64, print)
    assert overtaken == [[1, "", 0]]
    assert context_of(node).loop.run(subscription_of(node, "/u").has_publisher, newer)


def test_param_update_s09(node: Any, call_node: Any) -> None:
    assert call_node(node, "paramUpdate", "/master", "/x", 1) == [-1, "not subscribed", 0]
    assert call_node(node, "paramUpdate", "/master", "x", 1)[0] == -1
    assert call_node(node, "paramUpdate", "/master", 5, 1)[0] == -1
    node.params["x"] = 1
    assert node.params.cached("x") == 1
    assert call_node(node, "paramUpdate", "/master", "/x/", 2) == [1, "", 0]
    assert node.params.cached("x") == 2


@pytest.mark.parametrize("transport_name", ["TCPROS", "INTRAPROCESS"])
def test_bus_info_and_stats_s02_s03(
    make_node: Any, call_node: Any, collect: Any, monkeypatch: pytest.MonkeyPatch, transport_name: str
) -> None:
    if transport_name == "TCPROS":
        monkeypatch.setattr("pyros1.node.subscribing.connector.find_local_context", lambda uri: None)
    talker, listener, got = make_node("talker", rosout=False), make_node("listener", rosout=False), collect()
    listener.subscribe("t", Float64, got)
    publisher = talker.advertise("t", Float64)
    assert publisher.wait_for_subscribers(timeout=20)
    publisher.publish(1)
    publisher.publish(2)
    got.wait(2)
    code, _, [out] = call_node(talker, "getBusInfo", "/me")
    assert code == 1
    assert out[:6] == [0, "/listener", "o", transport_name, "/t", True]
    code, _, [into] = call_node(listener, "getBusInfo", "/me")
    assert into[:6] == [0, talker.uri, "i", transport_name, "/t", True]
    for info in (out[6], into[6]):
        import re

        assert re.fullmatch(rf"{transport_name} connection on port \d+ to \[[\w.]+:\d+ on socket \d+\]", info)
    size = 24 if transport_name == "TCPROS" else 0  # nothing is encoded within a process
    assert call_node(talker, "getBusStats", "/me") == [1, "", [[["/t", size, [[0, size, 2, True]]]], [], []]]
    assert call_node(listener, "getBusStats", "/me") == [1, "", [[], [["/t", [[0, size, 2, -1, True]]]], []]]


def test_stats_of_much_s02(make_node: Any, call_node: Any, collect: Any) -> None:
    """XML-RPC's integers end at 2 GB; in stock's rospy the call fails from then on."""
    talker, listener, got = make_node("talker", rosout=False), make_node("listener", rosout=False), collect()
    listener.subscribe("t", Float64, got)
    publisher = talker.advertise("t", Float64)
    assert publisher.wait_for_subscribers(timeout=20)
    publisher.links[0].bytes_sent, publisher.links[0].messages = 2**31, 2**31 - 1
    expected = [[["/t", 2.0**31, [[0, 2.0**31, 2**31 - 1, True]]]], [], []]
    assert call_node(talker, "getBusStats", "/me") == [1, "", expected]


def test_shutdown_s06(make_node: Any, call_node: Any, watch_log: Any) -> None:
    node = make_node("victim")
    node.log.level = DEBUG
    log = watch_log(node)
    ended = []
    node.on_shutdown(lambda: ended.append(1))
    assert call_node(node, "shutdown", "/me", 5)[0] == -1
    assert node.ok()
    assert call_node(node, "shutdown", "/me", "enough") == [1, "shutdown", 0]
    node.spin()
    node.shutdown()  # waits for the one under way
    assert ended == [1]
    assert "shutdown request: enough" in log.texts and "shutting down: enough" in log.texts


def test_shutdown_needs_no_reason_s06(make_node: Any, call_node: Any) -> None:
    node = make_node("victim")
    assert call_node(node, "shutdown", "/me") == [1, "shutdown", 0]
    node.spin()
    node.shutdown()


def test_an_end_that_is_meant_for_another_node_is_ignored_m34(make_node: Any, call_node: Any, watch_log: Any) -> None:
    """A node died, its port went to this one, and it was started again: the master ends who has the port now."""
    node = make_node("guest")
    log, ended = watch_log(node), threading.Event()
    node.on_shutdown(ended.set)
    assert call_node(node, "shutdown", "/master", "[/dead] Reason: new node registered with same name")[0] == 1
    assert log.saw("intended for /dead")
    assert not ended.is_set()
    call_node(node, "shutdown", "/master", "[/guest] Reason: new node registered with same name")
    assert ended.wait(10)


def test_bad_calls_m05_m06_s13(node: Any, call_node: Any) -> None:
    with pytest.raises(XmlRpcFault, match='method "nonsense" is not supported'):
        call_node(node, "nonsense", "/me")
    with pytest.raises(XmlRpcFault):
        call_node(node, "_shutdown", "/me")
    assert call_node(node, "getPid") == [-1, "missing required caller_id parameter", 0]
    assert call_node(node, "getPid", 5) == [-1, "caller_id must be a string", 0]
    for method in ("BusInfo", "BusStats", "MasterUri", "Name", "Pid", "Publications", "Subscriptions", "Uri"):
        assert call_node(node, f"get{method}", "/me", 1) == [-1, "Error: bad call arity", 0]
    assert call_node(node, "requestTopic", "/me", "/t") == [-1, "Error: bad call arity", 0]


def test_multicall_s01(node: Any, call_node: Any) -> None:
    calls = [{"methodName": "getPid", "params": ["/me"]}, {"methodName": "nonsense", "params": ["/me"]}]
    first, second = call_node(node, "system.multicall", calls)
    assert first == [[1, "", os.getpid()]]
    assert second["faultCode"] == 1
