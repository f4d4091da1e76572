"""Masters of other makes: without some methods, or refusing what others allow."""

from __future__ import annotations

import socket
import threading
from collections.abc import Callable
from typing import Any

import pytest

from pyros1.ground.errors import Error, MasterError, MasterMethodError, MasterUnreachableError, ProtocolError
from pyros1.msgs import AnyMsg
from pyros1.msgs.std_msgs.msg import Float64
from pyros1.net.master_client import MasterClient

from ..bodies import encode


@pytest.fixture
def refuse(monkeypatch: pytest.MonkeyPatch) -> Callable[[Callable[..., bool], Error], None]:
    """Return a function that lets masters answer with an error to the calls for which a function is true."""

    def install(is_refused: Callable[..., bool], error: Error) -> None:
        call = MasterClient.call

        def call_or_refuse(client: MasterClient, method: str, *args: Any, **options: Any) -> Any:
            if is_refused(method, *args):
                raise error
            return call(client, method, *args, **options)

        def one(client: MasterClient, method: str, args: Any) -> Any:
            try:
                return call_or_refuse(client, method, *args)
            except Error as failure:
                return failure

        def multicall(client: MasterClient, calls: Any, **options: Any) -> list[Any]:
            return [one(client, method, args) for method, args in calls]

        monkeypatch.setattr(MasterClient, "call", call_or_refuse)
        monkeypatch.setattr(MasterClient, "multicall", multicall)

    return install


def is_any_type(method: str, *args: Any) -> bool:
    return method == "registerSubscriber" and args[1] == "*"


def test_where_subscribers_need_a_type_they_take_the_topics(make_node: Any, collect: Any, refuse: Any) -> None:
    got, publisher = collect(), make_node("talker").advertise("t", Float64)
    listener = make_node("listener")
    refuse(is_any_type, MasterError("a subscriber needs a type", 0))
    listener.subscribe("t", AnyMsg, got)
    assert publisher.wait_for_subscribers(timeout=20)
    publisher.publish(2)
    assert got.wait(1)[0]._buff == encode(Float64(2))


def test_a_topic_that_has_no_type_yet_cannot_be_subscribed_to_there(make_node: Any, refuse: Any) -> None:
    listener = make_node("listener")
    refuse(is_any_type, MasterError("a subscriber needs a type", 0))
    with pytest.raises(MasterError, match="a subscriber needs a type"):
        listener.subscribe("t", AnyMsg, print)
    listener.subscribe("t", Float64, print)


@pytest.mark.parametrize("error", [MasterMethodError("no lookupNode", -1), ProtocolError("nonsense")], ids=repr)
def test_a_master_that_cannot_say_whether_it_knows_a_node_has_not_been_restarted(
    make_node: Any, watch_log: Any, monkeypatch: pytest.MonkeyPatch, error: Exception
) -> None:
    monkeypatch.setattr("pyros1.node.registrar.CHECK_INTERVAL", 0.01)
    node = make_node("node")
    log, times, asked = watch_log(node), [0], threading.Event()

    def lookup_node(*_: object) -> str:
        times[0] += 1
        if times[0] == 3:
            asked.set()
        raise error

    monkeypatch.setattr(MasterClient, "lookup_node", lookup_node)
    node.advertise("t", Float64)
    assert asked.wait(10)
    assert not log.texts


def test_parameters_of_a_master_that_tells_no_changes_are_asked_for_each_time(
    make_node: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    node = make_node("node")

    def subscribe_param(*_: object) -> None:
        raise MasterMethodError("no subscribeParam", -1)

    monkeypatch.setattr(MasterClient, "subscribe_param", subscribe_param)
    assert node.params.cached("p", "default") == "default"
    for value in (1, 2):
        node.params["p"] = value
        assert node.params.cached("p", "default") == value


def is_log(method: str, *args: Any) -> bool:
    return method == "registerPublisher" and args[0] == "/rosout"


def test_a_node_whose_log_is_refused_does_not_start(make_node: Any, refuse: Any) -> None:
    refuse(is_log, MasterError("not this one"))
    with pytest.raises(MasterError, match="not this one"):
        make_node("node")


@pytest.mark.parametrize(
    ("error", "options"),
    [(MasterMethodError("no registerPublisher", -1), {}), (MasterError("not this one"), {"strict_names": False})],
    ids=["no method", "like rospy"],
)
def test_a_node_may_run_without_publishing_its_log(
    make_node: Any, refuse: Any, capfd: pytest.CaptureFixture[str], error: Error, options: dict[str, Any]
) -> None:
    refuse(is_log, error)
    node = make_node("node", **options)
    assert node.ok()
    node.shutdown()
    assert f"/rosout or the services for log levels are not available: {error}" in capfd.readouterr().err


def test_a_master_that_accepts_connections_and_does_not_answer_is_said_to_do_so(
    make_node: Any, environ: dict[str, str], monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("pyros1.node.registrar.PING_TIMEOUT", 0.5)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        uri = f"http://localhost:{silent.getsockname()[1]}/"
        with pytest.raises(MasterUnreachableError):
            make_node("node", environ={**environ, "ROS_MASTER_URI": uri}, wait_for_master=1.0)
    assert "it accepts connections, but did not answer within 0.5 s (was it stopped?)" in capfd.readouterr().err
