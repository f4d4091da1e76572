"""Services and parameters of one master that nodes of another one use, with eclipse-zenoh between them.

Feature: services of other masters: `pyros1 bridge --serve` and `--call`; errors, and lost sites, are errors at once
Feature: parameters of other masters that they let others read -- `pyros1 bridge param`
"""

from __future__ import annotations

import json
import threading
from collections.abc import Callable
from typing import Any

import pytest

from pyros1.bridge.parameters import (
    PARAMETER_SERVICE,
    ParameterRequest,
    decode_parameter_response,
    encode_parameter_request,
)
from pyros1.bridge.service_ends import PARAMETERS_CLASS
from pyros1.graph import Graph, probe_service
from pyros1.ground.errors import NodeShutdownError, ServiceError, ServiceRefusal
from pyros1.master.server import Master
from pyros1.msgs import AnyMsg
from pyros1.msgs.std_srvs.srv import SetBool, Trigger
from pyros1.net.hosts import parse_uri

from .conftest import RunningSite, wait_until

MakeSite = Callable[..., RunningSite]
Pair = tuple[RunningSite, RunningSite]
BASE = "{call: [{service: 'red:/slow', timeout: 0.5}, 'red:**']}"
RED = "{serve: ['/**'], deny_serve: ['/**/get_loggers', '/**/set_logger_level'], params: [/shared]}"


@pytest.fixture
def pair(make_site: MakeSite, endpoint: str) -> Pair:
    """A robot that serves everything, and a base that calls it."""
    base = make_site("base", BASE, (), (endpoint,))
    return make_site("red", RED, (endpoint,)), base


def has_service(site: RunningSite, name: str, there: bool = True) -> None:
    """Wait until somebody provides a service, or nobody."""
    graph = Graph(site.node.master)
    wait_until(lambda: (graph.service_uri(name) is not None) is there, f"{name} at {site.name}: {there}")


def test_a_call_its_type_and_its_errors(pair: Pair) -> None:
    red, base = pair
    calls: list[bool] = []

    def switch(request: Any) -> tuple[bool, str]:
        calls.append(request.data)
        if not request.data:
            raise ServiceRefusal("the arm is folded")
        return True, "on"

    red.node.advertise_service("/switch", SetBool, switch)
    has_service(base, "/red/switch")
    uri = base.node.master.lookup_service("/red/switch")
    header = probe_service("/red/switch", uri, "/test")
    assert (header["type"], header["md5sum"]) == ("std_srvs/SetBool", SetBool._md5sum)
    assert header["request_type"] == "std_srvs/SetBoolRequest"
    for persistent in (False, True):
        with base.node.service("/red/switch", SetBool, persistent=persistent) as client:
            for _ in range(2):
                assert client(True).message == "on"
            with pytest.raises(ServiceError) as caught:
                client(False)
            assert caught.value.answer == b"the arm is folded"
    assert calls == [True, True, False] * 2
    (status,) = [each for each in json.loads(base.bridge.status())["called"] if each["local"] == "/red/switch"]
    assert (status["calls"], status["errors"], status["last_error"]) == (6, 2, "the arm is folded")
    (served,) = [each for each in json.loads(red.bridge.status())["served"] if each["local"] == "/switch"]
    assert (served["calls"], served["errors"]) == (6, 2)


@pytest.mark.slow
def test_services_come_and_go(pair: Pair) -> None:
    red, base = pair
    service = red.node.advertise_service("/switch", Trigger, lambda _: (True, ""))
    has_service(base, "/red/switch")
    service.shutdown()
    has_service(base, "/red/switch", False)
    red.node.advertise_service("/switch", SetBool, lambda _: (True, ""))
    has_service(base, "/red/switch")
    assert base.node.service("/red/switch", SetBool)(True).success


@pytest.mark.slow
def test_a_service_of_a_local_node_is_not_replaced(pair: Pair) -> None:
    red, base = pair
    own = base.node.advertise_service("/red/switch", Trigger, lambda _: (True, "own"))
    red.node.advertise_service("/switch", Trigger, lambda _: (True, "red's"))
    red.node.advertise_service("/other", Trigger, lambda _: (True, ""))
    has_service(base, "/red/other")
    client = base.node.service("/red/switch", Trigger)
    assert client().message == "own"
    (status,) = [each for each in json.loads(base.bridge.status())["called"] if each["local"] == "/red/switch"]
    assert status["state"] == "/user already provides /red/switch here"
    own.shutdown()
    has_service(base, "/red/switch")
    assert client().message == "red's"


def test_large_requests_and_responses(pair: Pair) -> None:
    red, base = pair
    text = "x" * 3_000_000
    red.node.advertise_service("/large", Trigger, lambda _: (True, text))
    has_service(base, "/red/large")
    assert base.node.service("/red/large", Trigger)().message == text


@pytest.mark.slow
def test_a_service_that_takes_too_long(pair: Pair) -> None:
    red, base = pair
    end = threading.Event()

    def wait(_: Any) -> tuple[bool, str]:
        end.wait(20)
        return True, ""

    red.node.advertise_service("/slow", Trigger, wait)
    try:
        has_service(base, "/red/slow")
        with pytest.raises(
            ServiceError, match="red:/slow has not answered in time; the call may have been carried out"
        ):
            base.node.service("/red/slow", Trigger)()
    finally:
        end.set()


def test_calls_that_the_end_of_a_bridge_cuts_short_are_not_called_refused(
    pair: Pair, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They may have been carried out: the node's end can reach them before the bridge has said that it leaves."""
    red, base = pair
    cut_short = threading.Event()

    def call(*_: object, **_options: object) -> None:
        cut_short.set()
        raise NodeShutdownError("shutting down")

    red.node.advertise_service("/cut", Trigger, lambda _: (True, ""))
    has_service(base, "/red/cut")
    monkeypatch.setattr(red.bridge_node, "service", call)
    errors: list[str] = []

    def use() -> None:
        try:
            base.node.service("/red/cut", Trigger)()
        except ServiceError as error:
            errors.append(str(error))

    thread = threading.Thread(target=use)
    thread.start()
    assert cut_short.wait(20)
    red.bridge_node.shutdown()
    thread.join(20)
    assert len(errors) == 1 and "site red has left; the call may have been carried out, or not" in errors[0]
    red.restart_bridge()


@pytest.mark.slow
def test_a_bridge_that_leaves_ends_its_calls(pair: Pair) -> None:
    red, base = pair
    begun, end = threading.Event(), threading.Event()

    def wait(_: Any) -> tuple[bool, str]:
        begun.set()
        end.wait(20)
        return True, ""

    red.node.advertise_service("/wait", Trigger, wait)
    has_service(base, "/red/wait")
    errors: list[str] = []

    def call() -> None:
        try:
            base.node.service("/red/wait", Trigger)()
        except ServiceError as error:
            errors.append(str(error))

    thread = threading.Thread(target=call)
    thread.start()
    try:
        assert begun.wait(20)
        red.bridge_node.shutdown()
        thread.join(20)
        assert len(errors) == 1 and "site red has left; the call may have been carried out, or not" in errors[0]
        has_service(base, "/red/wait", False)
    finally:
        end.set()
        thread.join()
    red.restart_bridge()
    has_service(base, "/red/wait")
    assert base.node.service("/red/wait", Trigger)().success


@pytest.mark.slow
def test_many_calls_at_once(pair: Pair) -> None:
    red, base = pair
    red.node.advertise_service("/switch", SetBool, lambda request: (request.data, "done"))
    has_service(base, "/red/switch")
    results: list[Any] = []

    def call() -> None:
        for number in range(20):
            results.append(base.node.service("/red/switch", SetBool)(number % 2 == 0).success is (number % 2 == 0))

    threads = [threading.Thread(target=call) for _ in range(10)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
    assert results == [True] * 200


@pytest.mark.slow
def test_no_loops(make_site: MakeSite, endpoint: str) -> None:
    everything = "{serve: ['/**'], call: ['*:**']}"
    base = make_site("base", everything, (), (endpoint,))
    red = make_site("red", everything, (endpoint,))
    red.node.advertise_service("/switch", Trigger, lambda _: (True, ""))
    base.node.advertise_service("/last", Trigger, lambda _: (True, ""))
    has_service(base, "/red/switch")
    has_service(red, "/base/last")
    for site, other in ((red, base), (base, red)):  # when these have come, the bridges have looked once more
        site.node.advertise_service("/later", Trigger, lambda _: (True, ""))
        has_service(other, f"/{site.name}/later")
    expected = {(site.name, f"/{other.name}/later") for site, other in ((red, base), (base, red))}
    found = {
        (site.name, name)
        for site in (base, red)
        for name in Graph(site.node.master).state().services
        if name.startswith(("/red/", "/base/")) and "logger" not in name
    }
    assert found == expected | {("base", "/red/switch"), ("red", "/base/last")}


@pytest.mark.slow
def test_the_master_is_away_for_a_while(pair: Pair) -> None:
    red, base = pair
    red.node.advertise_service("/switch", Trigger, lambda _: (True, ""))
    has_service(base, "/red/switch")
    port = parse_uri(base.master.uri)[1]
    base.master.stop()
    base.master = Master(port=port, bind_host="127.0.0.1")
    base.master.start()
    has_service(base, "/red/switch")
    assert base.node.service("/red/switch", Trigger)().success


def test_parameters(pair: Pair) -> None:
    red, base = pair
    red.node.master.set_param("/shared", {"speed": 1.5})
    red.node.master.set_param("/secret", 1)
    client = base.node.service(f"/bridge_base/{PARAMETER_SERVICE}", PARAMETERS_CLASS)

    def ask(name: str) -> Any:
        return decode_parameter_response(client(AnyMsg(encode_parameter_request(ParameterRequest("red", name))))._buff)

    def is_there() -> bool:
        try:
            return bool(ask("") == ["/shared/speed"])
        except ServiceError:
            return False

    wait_until(is_there, "red's parameters")
    assert ask("/shared") == {"speed": 1.5}
    with pytest.raises(ServiceError, match="site red has no parameter /secret that others may read"):
        ask("/secret")
    with pytest.raises(ServiceError, match="not a request"):
        client(AnyMsg(b"?"))
    assert not any("parameters" in name for name in Graph(base.node.master).state().services if "red" in name)
