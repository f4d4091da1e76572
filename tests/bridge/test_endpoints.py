"""Endpoints, and where a site may listen."""

from __future__ import annotations

import pytest

from pyros1.bridge.endpoints import EndpointError, check_endpoint, check_listening, is_local


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
def test_listening_beyond_this_machine_is_refused(endpoint: str, local: bool) -> None:
    assert is_local(endpoint) == local
    check_listening([endpoint], insecure=True)
    if local:
        check_listening([endpoint], insecure=False)
    else:
        with pytest.raises(EndpointError, match="allow it with --insecure"):
            check_listening([endpoint], insecure=False)
