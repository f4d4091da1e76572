"""services: calls between nodes of one machine and user go over Unix sockets.

Feature: between nodes on one machine, large messages go through shared memory, small ones and service calls over Unix
    sockets
"""

from __future__ import annotations

from typing import Any

import pytest

from pyros1.ground.errors import ServiceError
from pyros1.msgs.roscpp.srv import SetLoggerLevel
from pyros1.msgs.std_srvs.srv import Empty, SetBool
from pyros1.node import same_host

from ...parts import on_loop

pytestmark = pytest.mark.skipif(not same_host.host_key(), reason="no such sockets on this system")


@pytest.fixture(autouse=True)
def _local(environ: dict[str, str]) -> None:
    del environ["PYROS1_TRANSPORTS"]


def answer(request: Any) -> Any:
    return True, "x" * 300_000


def refuse(*args: Any) -> Any:
    raise ConnectionRefusedError


@pytest.fixture
def no_tcp(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.node.services.provider_connection.blocking_connect", refuse)


@pytest.mark.usefixtures("no_tcp")
@pytest.mark.parametrize("persistent", [False, True])
@pytest.mark.parametrize("size", [3, 65_000, 66_000, 1_000_000])
def test_no_tcp_is_needed(make_node: Any, persistent: bool, size: int) -> None:
    provider, got = make_node("provider"), []
    provider.advertise_service("s", SetLoggerLevel, lambda request: got.append(request.logger) or {})
    provider.advertise_service("long", SetBool, answer)
    on_loop(provider)
    caller = make_node("caller")
    caller.wait_for_service("s", timeout=5)
    with (
        caller.service("s", SetLoggerLevel, persistent=persistent) as client,
        caller.service("long", SetBool, persistent=persistent) as other,
    ):
        for number in range(3):
            client(str(number) * size, "debug")
            assert len(other(True).message) == 300_000
    assert got == [str(number) * size for number in range(3)]


@pytest.mark.usefixtures("no_tcp")
@pytest.mark.parametrize("size", [3, 66_000])
def test_a_refusal_is_read(make_node: Any, size: int) -> None:
    provider, caller = make_node("provider"), make_node("caller")
    provider.advertise_service("s", Empty, lambda request: {})
    on_loop(provider)
    with pytest.raises(ServiceError, match="md5sum"):
        caller.service("s", SetLoggerLevel)("x" * size, "debug")


@pytest.mark.usefixtures("no_tcp")
def test_a_node_with_no_service_of_a_program_listens_on_tcp_only(make_node: Any) -> None:
    provider, caller = make_node("provider"), make_node("caller")
    with pytest.raises(ServiceError, match="cannot be reached"):
        caller.service("provider/set_logger_level", SetLoggerLevel)("rosout", "debug")
    assert provider.name == "/provider"


@pytest.mark.parametrize("side", ["client", "provider"])
def test_other_users_and_machines_have_tcp(make_node: Any, monkeypatch: pytest.MonkeyPatch, side: str) -> None:
    if side == "client":
        monkeypatch.setattr("pyros1.node.same_host.is_same_user", lambda sock: False)
    else:
        monkeypatch.setattr("pyros1.node.same_host.listen", lambda wish: refuse())
        monkeypatch.setattr("pyros1.node.server.listen", lambda wish: refuse())
    provider, caller = make_node("provider"), make_node("caller")
    provider.advertise_service("s", SetBool, answer)
    on_loop(provider)
    assert caller.service("s", SetBool)(True).success


def test_a_setting_leaves_tcp(make_node: Any, environ: dict[str, str]) -> None:
    provider = make_node("provider")
    provider.advertise_service("s", SetBool, answer)
    on_loop(provider)
    environ["PYROS1_TRANSPORTS"] = "tcp"
    caller = make_node("caller")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("pyros1.node.services.provider_connection.blocking_connect", refuse)
        with pytest.raises(ServiceError, match="cannot be reached"):
            caller.service("s", SetBool)(True)
    assert caller.service("s", SetBool)(True).success
