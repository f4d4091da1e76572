"""Why connections between sites fail, as users are told."""

from __future__ import annotations

import socket

import pytest

from pyros1.bridge.transport.failures import explain_dialling, explain_listening, first_sentence

ERROR = RuntimeError("Unable to connect to any of [Single(tcp/x:1)]. Timeout! at zenoh/src/net.rs:1.")


def test_a_port_on_which_nobody_listens() -> None:
    with socket.socket() as unused:
        unused.bind(("127.0.0.1", 0))
        endpoint = f"tls/127.0.0.1:{unused.getsockname()[1]}"
        assert explain_dialling(ERROR, endpoint) == f"cannot reach {endpoint}: Connection refused"


@pytest.mark.parametrize(("protocol", "cure"), [("tls", "with the name 127.0.0.1"), ("tcp", "connect to tls/")])
def test_a_port_on_which_another_listens(protocol: str, cure: str) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        assert cure in explain_dialling(ERROR, f"{protocol}/127.0.0.1:{server.getsockname()[1]}")


def test_other_reasons() -> None:
    assert explain_dialling(ERROR, "quic/x:1") == first_sentence(ERROR)
    assert explain_listening(ERROR, ["tcp/x:1"]) == "Unable to connect to any of [Single(tcp/x:1)]. Timeout!"
    used = RuntimeError("Can not create a new TCP listener bound to tcp/x:1#so_sndbuf=1: [x:1: Address already in use")
    assert explain_listening(used, ["tcp/x:1"]).startswith("tcp/x:1 is in use by another program")
