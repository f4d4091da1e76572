"""services: what is said of providers that cannot be asked, and of waiting for them."""

from __future__ import annotations

from typing import Any

import pytest

from pyros1.ground.errors import (
    MasterMethodError,
    NodeShutdownError,
    ServiceError,
    ServiceUnavailableError,
    WaitTimeoutError,
)
from pyros1.msgs.sensor_msgs.msg import CameraInfo
from pyros1.msgs.sensor_msgs.srv import SetCameraInfo
from pyros1.msgs.std_srvs.srv import Empty
from pyros1.net.master_client import MasterClient
from pyros1.node.services.client import PROBE_TIMEOUT, probe
from pyros1.wire.header import encode_header

from ...parts import context_of


@pytest.fixture
def fake(fake_node: Any) -> Any:
    fake = fake_node("/fake")
    fake.service_uri = f"rosrpc://localhost:{fake.port}"
    fake.master.register_service("/s", fake.service_uri, fake.uri)
    return fake


@pytest.fixture
def no_lookup(monkeypatch: pytest.MonkeyPatch) -> None:
    """A master that does not have the method."""

    def refuse(*_: object) -> str:
        raise MasterMethodError("the master has no method lookupService", -1)

    monkeypatch.setattr(MasterClient, "lookup_service", refuse)


def test_a_master_that_cannot_look_up_services(make_node: Any, no_lookup: None) -> None:
    caller = make_node("caller")
    with pytest.raises(ServiceError, match=r"service \[/s\] cannot be looked up: .*no method lookupService"):
        caller.service("s", Empty)()
    with pytest.raises(ServiceError, match=r"cannot wait for service \[/s\]: .*no method lookupService"):
        caller.wait_for_service("s", timeout=5)


@pytest.mark.parametrize(
    ("answer", "error"),
    [
        (encode_header({"error": "not\nfor you"}), r"service \[/s\] at rosrpc://localhost:\d+: not.*for you$"),
        (b"\xff" * 100, r"service \[/s\] at rosrpc://localhost:\d+ does not answer: "),
        (b"", r"service \[/s\] at rosrpc://localhost:\d+ does not answer: the provider closed the connection"),
    ],
)
def test_a_provider_that_refuses_to_be_asked(
    make_node: Any, fake: Any, in_thread: Any, answer: bytes, error: str
) -> None:
    asking = in_thread(probe, context_of(make_node("caller")), "/s", fake.service_uri, 5.0)
    sock, header = fake.accept()
    assert (header["probe"], header["service"], header["md5sum"]) == ("1", "/s", "*")
    sock.sendall(answer)
    sock.close()
    with pytest.raises(ServiceUnavailableError, match=error):
        asking.join()


def test_waiting_for_a_silent_provider_says_that_it_does_not_answer(
    make_node: Any, fake: Any, in_thread: Any, watch_log: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.node.services.client.PROBE_TIMEOUT", 0.02)
    caller = make_node("caller")
    log = watch_log(caller)
    with pytest.raises(
        WaitTimeoutError, match=r"registered at rosrpc://.*, but does not answer \(was its node stopped"
    ):
        caller.wait_for_service("s", timeout=1.5)
    waiting = in_thread(caller.wait_for_service, "s")
    log.saw(f"waiting for service /s: registered at {fake.service_uri}, but does not answer (was its node stopped?)")
    caller.shutdown()
    with pytest.raises(NodeShutdownError):
        waiting.join()


def test_a_provider_may_answer_within_the_time_that_is_left(
    make_node: Any, fake: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    timeouts: list[float] = []

    def refuse(context: Any, service: str, uri: str, timeout: float) -> None:
        timeouts.append(timeout)
        raise ServiceUnavailableError("silent")

    monkeypatch.setattr("pyros1.node.services.client.probe", refuse)
    for timeout in (0.01, 2.0):
        with pytest.raises(WaitTimeoutError):
            make_node("caller").wait_for_service("s", timeout=timeout)
    assert timeouts[0] == 0.1 and timeouts[-1] == min(2.0, PROBE_TIMEOUT)


def test_a_message_as_the_only_field_of_a_request(make_node: Any) -> None:
    make_node("server").advertise_service(
        "s", SetCameraInfo, lambda request: (True, request.camera_info.distortion_model)
    )
    client = make_node("caller").service("s", SetCameraInfo)
    assert client(CameraInfo(distortion_model="plumb_bob")).status_message == "plumb_bob"
