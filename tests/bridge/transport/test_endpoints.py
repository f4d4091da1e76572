"""Endpoints, and where a site may listen."""

from __future__ import annotations

import pytest

from pyros1.bridge.transport.endpoints import EndpointError, check_endpoint, check_reachable, check_security, is_local


@pytest.mark.parametrize(
    "text",
    ["tcp/base.example:7447", "tls/[::]:7447", "tcp/[fe80::1%eth0]:1", "unixsock-stream//tmp/x", "quic/1.2.3.4:5"],
)
def test_endpoints(text: str) -> None:
    assert check_endpoint(text) == text


@pytest.mark.parametrize(
    "text",
    ["", "tcp", "base:7447", "tcp/base", "tcp/base:99999", "serial//dev/x:1", "tcp/a b:1", "tcp/::1:7", "tcp/a:7#x"],
)
def test_what_is_no_endpoint(text: str) -> None:
    with pytest.raises(EndpointError, match="is not an endpoint"):
        check_endpoint(text)


@pytest.mark.parametrize(
    ("endpoint", "local"),
    [
        ("tcp/127.0.0.1:1", True),
        ("tcp/localhost:1", True),
        ("tcp/[::1]:1", True),
        ("unixsock-stream//tmp/x", True),
        ("tcp/[::]:1", False),
        ("tcp/0.0.0.0:1", False),
        ("tls/base.example:1", False),
        ("tcp/127.0.0.1.example:1", False),
        ("tcp/localhost.example:1", False),
    ],
)
def test_unencrypted_endpoints_beyond_this_machine_are_refused(endpoint: str, local: bool) -> None:
    assert is_local(endpoint) == local
    if endpoint.startswith("tls"):
        return
    for connect, listen, complaint in (
        ([endpoint], [], "is not encrypted: .* allow it with --insecure"),
        ([], [endpoint], "can be reached from other machines, .* allow it with --insecure"),
    ):
        check_security(connect, listen, has_keys=False, insecure=True)
        if local:
            check_security(connect, listen, has_keys=False, insecure=False)
        else:
            with pytest.raises(EndpointError, match=complaint):
                check_security(connect, listen, has_keys=False, insecure=False)
        with pytest.raises(EndpointError, match=r"cannot use the keys: use tls/.*, or leave --keys out"):
            check_security(connect, listen, has_keys=True, insecure=True)


@pytest.mark.parametrize("endpoint", ["tls/[::]:1", "quic/base.example:1", "tls/127.0.0.1:1"])
@pytest.mark.parametrize("insecure", [False, True])
def test_encrypted_endpoints_need_keys(endpoint: str, insecure: bool) -> None:
    for connect, listen in (([endpoint], []), ([], [endpoint])):
        check_security(connect, listen, has_keys=True, insecure=insecure)
        with pytest.raises(EndpointError, match=r"needs keys: make them with `pyros1 bridge keys`.*--keys"):
            check_security(connect, listen, has_keys=False, insecure=insecure)


def test_the_encrypted_form_is_named() -> None:
    with pytest.raises(EndpointError, match=r"Use tls/\[::\]:7447 with --keys"):
        check_security([], ["tcp/[::]:7447"], has_keys=False, insecure=False)


def test_what_zenoh_never_connects_to() -> None:
    for endpoint in ("tls/[::1]:7447", "quic/[fe80::1]:7447"):
        with pytest.raises(EndpointError, match="Use a host name for this IPv6 address"):
            check_reachable(endpoint)
    for endpoint in ("tls/base.example:7447", "tls/10.0.0.1:7447", "tcp/[::1]:7447"):
        check_reachable(endpoint)
