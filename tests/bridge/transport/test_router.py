"""A router alone, on loopback."""

from __future__ import annotations

import socket
from pathlib import Path

import pytest

from pyros1.bridge.rules.site_access import SiteAccess
from pyros1.bridge.transport.access_control import security_settings
from pyros1.bridge.transport.certificates import load_keys, make_keys
from pyros1.bridge.transport.router import Router
from pyros1.bridge.transport.zenoh_link import LinkError

from ..conftest import wait_until
from .stations import Station

pytest.importorskip("zenoh")
pytest.importorskip("cryptography")


def has_ipv6() -> bool:
    try:
        with socket.socket(socket.AF_INET6) as unused:
            unused.bind(("::1", 0))
    except OSError:
        return False
    return True


@pytest.mark.parametrize("listen", ["tls/127.0.0.1", "tls/[::]", "quic/127.0.0.1"])
def test_sites_reach_each_other(tmp_path: Path, free_port: int, listen: str) -> None:
    if "[" in listen and not has_ipv6():
        pytest.skip("no IPv6")
    make_keys(tmp_path / "keys", {"router": ["127.0.0.1", "localhost"], "red": [], "base": []})
    settings = security_settings(load_keys(tmp_path / "keys" / "router"), [SiteAccess("red"), SiteAccess("base")])
    router = Router([], [f"{listen}:{free_port}"], settings)
    stations = []
    try:
        for name, host in (("red", "127.0.0.1"), ("base", "localhost")):
            endpoint = f"{listen.partition('/')[0]}/{host}:{free_port}"
            stations.append(Station(tmp_path / "keys" / name, connect=[endpoint]))
        red, base = stations
        assert base.heard("red/hello", lambda body: red.put("red/hello", body)) == set()
        found = router.connections()
        assert sorted(each.certificate for each in found) == ["base", "red"]
        assert all(each.address.startswith("127.0.0.1:") for each in found)
        base.close()
        wait_until(lambda: [each.certificate for each in router.connections()] == ["red"], "base is gone")
    finally:
        for station in stations:
            station.close()
        router.close()


def test_a_port_that_is_taken(free_port: int) -> None:
    router = Router([], [f"tcp/127.0.0.1:{free_port}"], {})
    try:
        with pytest.raises(LinkError, match=r"cannot start the router: .*in use"):
            Router([], [f"tcp/127.0.0.1:{free_port}"], {})
    finally:
        router.close()
