"""Services that a running bridge to ROS 2 exchanges.

Feature: services of ROS 2 nodes that use rmw_zenoh -- `pyros1 bridge ros2`, both ways
"""

from __future__ import annotations

import json
import struct
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("zenoh")

from pyros1.bridge.status import status_lines
from pyros1.ground.errors import ServiceError, ServiceRefusal
from pyros1.ros2.bridge import services
from pyros1.ros2.zenoh.attachments import Attachment, decode_attachment, encode_attachment
from pyros1.ros2.zenoh.calls import IncomingCall
from pyros1.ros2.zenoh.names import DataKey, data_key

from ...bridge.conftest import PATIENCE, wait_until
from .test_running import Ros2Peer, RunningBridge, endpoint

__all__ = ["endpoint"]

SET_BOOL = "RIHS01_abe9e4bb6b41b40e6789712c00ec8871923e089af3f667a79992a428cff2da0a"
"""The hash of std_srvs/srv/SetBool, as ROS 2 Kilted has it."""
EMPTY = "RIHS01_5888399dedec5ccc85ea6451949fd2c9f97bfdf963f9a588821639fcd31b5d19"
CALL_TIME = 20.0
HEAD = b"\0\1\0\0"


def key(name: str, type: str = "std_srvs/srv/SetBool", hash: str = SET_BOOL) -> DataKey:
    return DataKey(0, name, type, hash)


def response(success: bool, text: str) -> bytes:
    """Return a response of std_srvs/srv/SetBool as CDR."""
    data = text.encode() + b"\0"
    return HEAD + struct.pack("<?3xI", success, len(data)) + data


@pytest.fixture
def bridge(endpoint: str, tmp_path: Path) -> Iterator[RunningBridge]:
    running = RunningBridge(tmp_path, listen=[endpoint])
    yield running
    running.close()


@pytest.fixture
def peer(bridge: RunningBridge, endpoint: str) -> Iterator[Ros2Peer]:
    peer = Ros2Peer(endpoint)
    yield peer
    peer.session.close()


def await_offer(peer: Ros2Peer, name: str) -> None:
    wait_until(lambda: peer.graph.service(name).servers, f"ROS 2 sees {name}")


def await_service(bridge: RunningBridge, name: str) -> None:
    wait_until(lambda: name in bridge.services(), f"ROS 1 sees {name}")


def test_ros2_calls_a_service_of_ros1(bridge: RunningBridge, peer: Ros2Peer) -> None:
    bridge.node.advertise_service("/switch", "std_srvs/SetBool", lambda request: (not request.data, "switched"))
    await_offer(peer, "/switch")
    (seen,) = peer.graph.service("/switch").servers
    assert (seen.type, seen.hash, seen.node_name) == ("std_srvs/srv/SetBool", SET_BOOL, "bridge")
    peer.make_client(key("/switch"))
    assert peer.session.call(key("/switch"), HEAD + b"\1", CALL_TIME) == response(False, "switched")
    assert peer.session.call(key("/switch"), HEAD + b"\0", CALL_TIME) == response(True, "switched")
    wait_until(lambda: bridge.status()["served"][0]["calls"] == 2, "the calls are counted")
    (served,) = bridge.status()["served"]
    assert served == {
        "service": "/switch",
        "local": "/switch",
        "type": "std_srvs/SetBool",
        "calls": 2,
        "errors": 0,
        "last_error": "",
    }
    assert "lets others call:" in [*status_lines(bridge.status())]


class Answers:
    """The replies to a call that is made as programs may make it that are not ROS 2 nodes."""

    def __init__(self, peer: Ros2Peer, name: DataKey | str, body: bytes | None, attachment: bytes | None) -> None:
        self.replies: list[Any] = []
        self._ended = threading.Event()
        session: Any = peer.session.session
        handler = peer.session.zenoh.handlers.Callback(self.replies.append, self._ended.set)
        selector = name if isinstance(name, str) else data_key(name)
        session.get(selector, handler, payload=body, attachment=attachment, timeout=CALL_TIME)

    def get(self) -> list[Any]:
        assert self._ended.wait(PATIENCE)
        return self.replies


def test_a_response_says_whose_it_is(bridge: RunningBridge, peer: Ros2Peer) -> None:
    bridge.node.advertise_service("/switch", "std_srvs/SetBool", lambda request: (True, ""))
    await_offer(peer, "/switch")
    asked = Attachment(7, 8, bytes(range(16)))
    (reply,) = Answers(peer, key("/switch"), HEAD + b"\1", encode_attachment(asked)).get()
    said = decode_attachment(reply.ok.attachment.to_bytes())
    assert said is not None and (said.sequence_number, said.gid) == (7, asked.gid) and said.source_time > 8


def test_damaged_calls_of_ros2(bridge: RunningBridge, peer: Ros2Peer) -> None:
    called: list[Any] = []
    bridge.node.advertise_service("/switch", "std_srvs/SetBool", called.append)
    await_offer(peer, "/switch")
    good = encode_attachment(Attachment(1, 1, bytes(16)))
    for attachment in (None, b"", good[:-1], bytes(2000)):
        assert Answers(peer, key("/switch"), HEAD + b"\1", attachment).get() == []
    assert Answers(peer, key("/switch"), None, good).get() == []
    assert Answers(peer, "0/**", HEAD + b"\1", good).get() == []
    wait_until(lambda: bridge.status()["served"][0]["errors"] == 6, "they are counted")
    assert bridge.status()["served"][0]["last_error"] == "a request without a valid attachment was dropped"
    for body in (b"", b"\0\1\0", HEAD, b"\7\7\7\7\1"):
        (reply,) = Answers(peer, key("/switch"), body, good).get()
        assert b"cannot convert a std_srvs/srv/SetBool_Request" in reply.err.payload.to_bytes()
    assert not called


def test_ros2_calls_a_service_of_ros1_that_fails(bridge: RunningBridge, peer: Ros2Peer) -> None:
    def fail(request: Any) -> Any:
        raise ServiceRefusal("the arm is folded")

    bridge.node.advertise_service("/switch", "std_srvs/SetBool", fail)
    await_offer(peer, "/switch")
    peer.make_client(key("/switch"))
    with pytest.raises(ServiceRefusal, match=r"does not respond: the arm is folded$"):
        peer.session.call(key("/switch"), HEAD + b"\1", CALL_TIME)
    assert bridge.status()["served"][0]["last_error"] == "the arm is folded"


def test_ros2_calls_a_service_of_ros1_that_takes_too_long(endpoint: str, tmp_path: Path) -> None:
    bridge = RunningBridge(tmp_path, call_time=0.2, listen=[endpoint])
    released = threading.Event()
    try:
        peer = Ros2Peer(endpoint)
        bridge.node.advertise_service("/switch", "std_srvs/SetBool", lambda _: (released.wait(PATIENCE), ""))
        await_offer(peer, "/switch")
        peer.make_client(key("/switch"))
        with pytest.raises(ServiceRefusal, match="did not answer in time"):
            peer.session.call(key("/switch"), HEAD + b"\1", CALL_TIME)
    finally:
        released.set()
        bridge.close()
        peer.session.close()


def test_ros1_calls_a_service_of_ros2(bridge: RunningBridge, peer: Ros2Peer) -> None:
    peer.offer(key("/switch"))
    await_service(bridge, "/switch")
    (seen,) = peer.graph.service("/switch").clients
    assert (seen.type, seen.hash, seen.node_name) == ("std_srvs/srv/SetBool", SET_BOOL, "bridge")
    with bridge.node.service("/switch", "std_srvs/SetBool") as client, Call(client, True) as call:
        asked = peer.calls.get(timeout=PATIENCE)
        assert asked.body == HEAD + b"\1" and asked.origin is not None and asked.origin.sequence_number == 1
        asked.respond(response(True, "on"))
        result = call.result()
    assert (result.success, result.message) == (True, "on")
    (called,) = bridge.status()["called"]
    assert called == {
        "service": "/switch",
        "from": "ROS 2",
        "local": "/switch",
        "type": "std_srvs/SetBool",
        "state": "",
        "calls": 1,
        "errors": 0,
        "last_error": "",
    }
    assert "provides services of others:" in [*status_lines(bridge.status())]


class Call:
    """A call of a ROS 1 node, in a thread."""

    def __init__(self, client: Any, *args: Any) -> None:
        self._result: Any = None
        self._thread = threading.Thread(target=self._run, args=(client, args))

    def _run(self, client: Any, args: tuple[Any, ...]) -> None:
        try:
            self._result = client(*args)
        except ServiceError as error:
            self._result = error

    def __enter__(self) -> Call:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._thread.join(PATIENCE)

    def result(self) -> Any:
        self._thread.join(PATIENCE)
        assert not self._thread.is_alive()
        return self._result


def test_calls_without_values(bridge: RunningBridge, peer: Ros2Peer) -> None:
    peer.offer(key("/clear", "std_srvs/srv/Empty", EMPTY))
    bridge.node.advertise_service("/reset", "std_srvs/Empty", lambda _: ())
    await_service(bridge, "/clear")
    with bridge.node.service("/clear", "std_srvs/Empty") as client, Call(client) as call:
        asked = peer.calls.get(timeout=PATIENCE)
        assert asked.body == HEAD + b"\0", "ROS 2 has no empty types"
        asked.respond(HEAD + b"\0")
        assert not isinstance(call.result(), Exception)
    await_offer(peer, "/reset")
    peer.make_client(key("/reset", "std_srvs/srv/Empty", EMPTY))
    assert peer.session.call(key("/reset", "std_srvs/srv/Empty", EMPTY), HEAD + b"\0", CALL_TIME) == HEAD + b"\0"


def test_ros1_calls_a_service_of_ros2_that_fails(bridge: RunningBridge, peer: Ros2Peer) -> None:
    peer.offer(key("/switch"))
    await_service(bridge, "/switch")
    with bridge.node.service("/switch", "std_srvs/SetBool", persistent=True) as client:
        ends: list[tuple[Callable[[IncomingCall], object], str]] = [
            (lambda asked: asked.fail("not now"), "the service in ROS 2 does not respond: not now"),
            (lambda asked: asked.drop(), "the service in ROS 2 does not respond"),
            (lambda asked: asked.respond(HEAD + b"\1"), "cannot convert a std_srvs/srv/SetBool_Response"),
            (lambda asked: asked.respond(b""), "cannot convert a std_srvs/srv/SetBool_Response"),
        ]
        for end, text in ends:
            with Call(client, True) as call:
                end(peer.calls.get(timeout=PATIENCE))
                error = call.result()
            assert isinstance(error, ServiceError) and text in str(error)
    assert bridge.status()["called"][0]["errors"] == 4


def test_ros1_calls_a_service_of_ros2_that_takes_too_long(endpoint: str, tmp_path: Path) -> None:
    bridge = RunningBridge(tmp_path, call_time=0.2, listen=[endpoint])
    try:
        peer = Ros2Peer(endpoint)
        peer.offer(key("/switch"))
        await_service(bridge, "/switch")
        with (
            bridge.node.service("/switch", "std_srvs/SetBool") as client,
            Call(client, True) as call,
        ):
            error = call.result()
        assert isinstance(error, ServiceError) and "the service in ROS 2 does not respond" in str(error)
        asked = peer.calls.get(timeout=PATIENCE)
        asked.drop()
    finally:
        bridge.close()
        peer.session.close()


def test_services_that_end(bridge: RunningBridge, peer: Ros2Peer) -> None:
    server = bridge.node.advertise_service("/switch", "std_srvs/SetBool", lambda request: (True, ""))
    peer.offer(key("/other"))
    await_offer(peer, "/switch")
    await_service(bridge, "/other")
    server.shutdown()
    wait_until(lambda: not peer.graph.service("/switch").servers, "ROS 2 sees it no longer")
    with bridge.node.service("/other", "std_srvs/SetBool") as client, Call(client, True) as call:
        peer.calls.get(timeout=PATIENCE)
        peer.session.close()
        error = call.result()
    assert isinstance(error, ServiceError) and "the service in ROS 2 does not respond" in str(error)
    wait_until(lambda: "/other" not in bridge.services(), "ROS 1 sees it no longer")


def test_services_that_cannot_be_exchanged(bridge: RunningBridge, peer: Ros2Peer) -> None:
    peer.offer(key("/strange", "strange_srvs/srv/Type", "RIHS01_" + "0" * 64))
    peer.offer(key("/changed", hash="RIHS01_" + "0" * 64))
    bridge.node.advertise_service("/both", "std_srvs/SetBool", lambda request: (True, ""))
    peer.offer(key("/both"))
    wait_until(lambda: len(bridge.status()["problems"]) >= 3, "the status says why")
    problems = bridge.status()["problems"]
    assert "strange_srvs/Type" in problems["/strange"]
    assert problems["/changed"] == "ROS 2 has another definition of std_srvs/srv/SetBool than ROS 1 has here"
    assert problems["/both"] == "/user provides it in ROS 1, and /peer in ROS 2"


def test_two_bridges_of_one_master_call_in_no_circle(bridge: RunningBridge, peer: Ros2Peer, endpoint: str) -> None:
    second = bridge.make_bridge("another_bridge", "bridge", connect=[endpoint])
    statuses = lambda: [bridge.status(), json.loads(second.status())]  # noqa: E731
    bridge.node.advertise_service("/switch", "std_srvs/SetBool", lambda request: (True, "once"))
    wait_until(lambda: len(peer.graph.service("/switch").servers) == 2, "both bridges offer it")
    wait_until(lambda: all("/bridge" in status["problems"] for status in statuses()), "each sees the other")
    peer.offer(key("/other"))
    await_service(bridge, "/other")

    def called(status: Any) -> set[str]:
        return {*status["problems"], *(each["local"] for each in status["called"])}

    wait_until(lambda: all("/other" in called(status) for status in statuses()), "they plan")
    assert not any("/switch" in called(status) for status in statuses())
    assert not peer.graph.service("/other").servers[1:], "it is not offered again"


def test_a_service_that_ros2_begins_to_offer_later(bridge: RunningBridge, peer: Ros2Peer) -> None:
    bridge.node.advertise_service("/switch", "std_srvs/SetBool", lambda request: (True, ""))
    await_offer(peer, "/switch")
    peer.offer(key("/switch"))
    wait_until(lambda: "/switch" in bridge.status()["problems"], "the status says so")
    assert [each["service"] for each in bridge.status()["served"]] == ["/switch"], "nobody gives way"


def test_too_many_calls_at_once(endpoint: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.ros2.bridge.services.MAX_CALLS", 1)
    bridge = RunningBridge(tmp_path, listen=[endpoint])
    begun, released = threading.Event(), threading.Event()

    def wait(request: Any) -> tuple[bool, str]:
        begun.set()
        return released.wait(PATIENCE), "done"

    peer = Ros2Peer(endpoint)
    try:
        bridge.node.advertise_service("/switch", "std_srvs/SetBool", wait)
        await_offer(peer, "/switch")
        attachment = encode_attachment(Attachment(1, 1, bytes(16)))
        first = Answers(peer, key("/switch"), HEAD + b"\1", attachment)
        assert begun.wait(PATIENCE)
        (refused,) = Answers(peer, key("/switch"), HEAD + b"\1", attachment).get()
        assert refused.err.payload.to_bytes() == b"the bridge to ROS 1 has too many calls at once"
        released.set()
        (reply,) = first.get()
        assert reply.ok.payload.to_bytes() == response(True, "done")
    finally:
        released.set()
        bridge.close()
        peer.session.close()


@pytest.mark.slow
def test_a_client_with_many_calls_leaves_room_for_others(bridge: RunningBridge, peer: Ros2Peer) -> None:
    begun, released = threading.Semaphore(0), threading.Event()

    def wait(request: Any) -> tuple[bool, str]:
        if request.data:
            return True, "at once"
        begun.release()
        return released.wait(PATIENCE), "late"

    try:
        bridge.node.advertise_service("/switch", "std_srvs/SetBool", wait)
        await_offer(peer, "/switch")
        greedy, other = (encode_attachment(Attachment(1, 1, bytes([number]) * 16)) for number in (1, 2))
        calls = [Answers(peer, key("/switch"), HEAD + b"\0", greedy) for _ in range(services.MAX_CALLS)]
        for _ in range(services.MAX_CALLS // 2):
            assert begun.acquire(timeout=PATIENCE)
        (reply,) = Answers(peer, key("/switch"), HEAD + b"\1", other).get()
        assert reply.ok.payload.to_bytes() == response(True, "at once")
        released.set()
        assert sum(each.get()[0].ok is None for each in calls) == services.MAX_CALLS // 2, "the others were refused"
    finally:
        released.set()


def test_calls_end_with_the_bridge(bridge: RunningBridge, peer: Ros2Peer) -> None:
    begun, released = threading.Event(), threading.Event()

    def wait(request: Any) -> tuple[bool, str]:
        begun.set()
        return released.wait(PATIENCE), ""

    bridge.node.advertise_service("/switch", "std_srvs/SetBool", wait)
    await_offer(peer, "/switch")
    call = Answers(peer, key("/switch"), HEAD + b"\1", encode_attachment(Attachment(1, 1, bytes(16))))
    try:
        assert begun.wait(PATIENCE)
        bridge.bridge.close()
        assert all(reply.ok is None for reply in call.get())
        assert not [each for each in threading.enumerate() if each.name.startswith("/bridge_ros2:call")]
    finally:
        released.set()


def test_two_masters_with_ros2_between_them(bridge: RunningBridge, endpoint: str, tmp_path: Path) -> None:
    other = RunningBridge(tmp_path, name="other", connect=[endpoint])
    try:
        bridge.node.advertise_service("/switch", "std_srvs/SetBool", lambda request: (request.data, "here"))
        await_service(other, "/switch")
        with other.node.service("/switch", "std_srvs/SetBool") as client:
            assert client(True).message == "here"
        assert other.status()["served"] == [] and bridge.status()["called"] == [], "it does not come back"
    finally:
        other.close()
