"""Sites with keys on real connections: who may connect, and what each may send and read."""

from __future__ import annotations

import json
import queue
from collections.abc import Callable, Iterator
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

import pytest

from pyros1.bridge.exchange.actions import Send
from pyros1.bridge.names import SharedName
from pyros1.bridge.protocol.key_expressions import Key, call_key, direct_topic_key, peer_key, topic_key
from pyros1.bridge.rules.site_access import SiteAccess
from pyros1.bridge.transport.access_control import security_settings
from pyros1.bridge.transport.certificates import SiteKeys, load_keys, make_keys
from pyros1.bridge.transport.zenoh_link import ZenohLink, make_config

from ..conftest import PATIENCE, wait_until
from .stations import MODES, Station, access_of, put_all

pytest.importorskip("zenoh")
pytest.importorskip("cryptography")
ODOM = SharedName("red", "/odom")


class Site:
    """A link with keys, and what comes over it."""

    def __init__(self, keys: Path | SiteKeys, name: str, sites: list[str | SiteAccess], **endpoints: list[str]) -> None:
        """`name` is the one that it uses; its keys may be those of another site."""
        self.packets: queue.Queue[tuple[Key, bytes]] = queue.Queue()
        access = [SiteAccess(site) if isinstance(site, str) else site for site in sites]
        settings = security_settings(load_keys(keys) if isinstance(keys, Path) else keys, access, name)
        self.link = ZenohLink(name, self._receive, settings=settings, **endpoints)

    def _receive(self, key: Key, head: bytes, body: bytes) -> None:
        self.packets.put((key, body))

    def send(self, key: str, body: bytes) -> None:
        self.link.send(Send(key, b"head", body))

    def received_until(self, body: bytes, ask: Callable[[], object]) -> list[bytes]:
        """Repeat a question until this body comes, and return what came before it."""
        bodies: list[bytes] = []
        for _ in range(round(PATIENCE / 0.2)):
            ask()
            try:
                while True:
                    bodies.append(self.packets.get(timeout=0.2)[1])
                    if bodies[-1] == body:
                        return bodies[:-1]
            except queue.Empty:
                pass
        raise AssertionError(f"{body!r} did not come, but {bodies}")


@pytest.fixture
def make_site() -> Iterator[Callable[..., Site]]:
    """Return a function that makes sites; those that were made last are closed first."""
    sites: list[Site] = []

    def make(*args: Any, **options: Any) -> Site:
        sites.append(Site(*args, **options))
        return sites[-1]

    yield make
    for site in reversed(sites):
        site.link.close()


def test_sites_with_keys_exchange_packets_through_a_base(keys: Path, port: int, make_site: Callable[..., Site]) -> None:
    """Feature: sites of a bridge prove their names: `pyros1 bridge keys` makes keys for mutual TLS -- each site writes
    only under its own name
    """
    base = make_site(keys / "base", "base", ["red", "green"], listen=[f"tls/127.0.0.1:{port}"])
    red = make_site(keys / "red", "red", [], connect=[f"tls/127.0.0.1:{port}"])
    green = make_site(keys / "green", "green", [], connect=[f"tls/127.0.0.1:{port}"])
    green.received_until(b"hello", lambda: red.send("hello", b"hello"))
    base.received_until(b"hello", lambda: red.send("hello", b"hello"))
    red.received_until(b"hi red", lambda: base.send(peer_key("red"), b"hi red"))
    green.link.listen("red", topic_key(ODOM), True)
    green.received_until(b"odometry", lambda: red.send(topic_key(ODOM), b"odometry"))
    green.received_until(b"missed", lambda: red.send(direct_topic_key("green", ODOM), b"missed"))
    green.received_until(b"call", lambda: red.send(call_key("green", SharedName("green", "/add")), b"call"))


def test_a_site_cannot_write_under_the_name_of_another_one(
    keys: Path, port: int, make_site: Callable[..., Site]
) -> None:
    base = make_site(keys / "base", "base", ["red", "green"], listen=[f"tls/127.0.0.1:{port}"])
    green = make_site(keys / "green", "green", [], connect=[f"tls/127.0.0.1:{port}"])
    liar = make_site(keys / "green", "red", [], connect=[f"tls/127.0.0.1:{port}"])
    honest = make_site(keys / "red", "red", [], connect=[f"tls/127.0.0.1:{port}"])
    liar.received_until(b"to all", lambda: base.send("hello", b"to all"))  # it is connected
    for site in (base, green):

        def ask() -> None:
            liar.send("hello", b"forged")
            liar.send(peer_key("base"), b"forged")
            honest.send("hello", b"honest")

        ask()
        assert b"forged" not in site.received_until(b"honest", ask)


def test_packets_for_one_site_are_not_read_by_others(keys: Path, port: int, make_site: Callable[..., Site]) -> None:
    base = make_site(keys / "base", "base", ["red", "green"], listen=[f"tls/127.0.0.1:{port}"])
    spy = make_site(keys / "green", "red", [], connect=[f"tls/127.0.0.1:{port}"])  # subscribes to what is for red
    red = make_site(keys / "red", "red", [], connect=[f"tls/127.0.0.1:{port}"])
    red.received_until(b"secret", lambda: base.send(peer_key("red"), b"secret"))

    red.received_until(b"secret", lambda: base.send(direct_topic_key("red", ODOM), b"secret"))

    def ask() -> None:
        base.send(peer_key("red"), b"secret")
        base.send(direct_topic_key("red", ODOM), b"secret")
        base.send("hello", b"to all")

    assert b"secret" not in spy.received_until(b"to all", ask)


def test_a_site_that_is_not_named_gets_nothing(keys: Path, port: int, make_site: Callable[..., Site]) -> None:
    base = make_site(keys / "base", "base", ["red"], listen=[f"tls/127.0.0.1:{port}"])
    stranger = make_site(keys / "stranger", "stranger", [], connect=[f"tls/127.0.0.1:{port}"])
    red = make_site(keys / "red", "red", [], connect=[f"tls/127.0.0.1:{port}"])

    def ask() -> None:
        stranger.send("hello", b"here I am")
        base.send("hello", b"to all")
        red.send("hello", b"from red")

    base.received_until(b"from red", ask)
    red.received_until(b"to all", ask)
    assert b"here I am" not in base.received_until(b"from red", ask)
    assert stranger.packets.empty()


@pytest.mark.slow
def test_keys_of_another_authority_do_not_connect(
    keys: Path, tmp_path: Path, port: int, make_site: Callable[..., Site]
) -> None:
    make_keys(tmp_path / "others", {"red": []})
    base = make_site(keys / "base", "base", [], listen=[f"tls/127.0.0.1:{port}"])
    other_keys = load_keys(tmp_path / "others" / "red")
    careful = make_site(other_keys, "red", [], connect=[f"tls/127.0.0.1:{port}"])
    trusting = other_keys._replace(ca_certificate=keys / "red" / "ca.crt")  # so only the base can refuse
    refused = make_site(trusting, "red", [], connect=[f"tls/127.0.0.1:{port}"])
    red = make_site(keys / "red", "red", [], connect=[f"tls/127.0.0.1:{port}"])
    red.received_until(b"hello", lambda: base.send("hello", b"hello"))
    for other in (careful, refused):
        wait_until(lambda other=other: other.link.problem, "it does not connect")
        assert other.packets.empty()


@pytest.mark.parametrize("protocol", ["tls", "tcp"])
def test_without_keys_nobody_connects(keys: Path, port: int, make_site: Callable[..., Site], protocol: str) -> None:
    import zenoh

    base = make_site(keys / "base", "base", [], listen=[f"tls/127.0.0.1:{port}"])
    red = make_site(keys / "red", "red", [], connect=[f"tls/127.0.0.1:{port}"])
    base.received_until(b"hello", lambda: red.send("hello", b"hello"))
    settings = {"transport/link/tls/root_ca_certificate": json.dumps(str(keys / "red" / "ca.crt"))}
    settings["connect/timeout_ms"] = "1000"
    with pytest.raises(zenoh.ZError):
        zenoh.open(make_config(zenoh, "client", [f"{protocol}/127.0.0.1:{port}"], [], settings))


@pytest.mark.slow
def test_a_base_at_another_address_is_not_trusted(keys: Path, port: int, make_site: Callable[..., Site]) -> None:
    """Otherwise any site could pass itself off as the base."""
    make_site(keys / "green", "base", [], listen=[f"tls/127.0.0.1:{port}"])
    red = make_site(keys / "red", "red", [], connect=[f"tls/127.0.0.1:{port}"])
    wait_until(lambda: red.link.problem, "it refuses the base")


# What each site may do ------------------------------------------------------------------------------------------------


@MODES
def test_a_site_that_may_send_some_topics_can_do_nothing_else(
    port: int, make_station: Callable[..., Station], mode: str
) -> None:
    """Whatever it calls itself, and whether or not it says that it is a router."""
    access = access_of("{red: {send: [/odom, /camera/**, 'base:/goal'], deny_send: [/camera/raw]}, green: {}}")
    base = make_station("base", "router", access, listen=[f"tls/127.0.0.1:{port}"])
    red = make_station("red", mode, connect=[f"tls/127.0.0.1:{port}"])
    allowed = {"red/to/base", "red/to/green", "red/t/red/odom", "red/again/green/red/odom", "red/t/red/camera/image"}
    allowed |= {"red/t/base/goal", "red/again/base/base/goal"}
    denied = {"red/t/red/scan", "red/t/red/odom/raw", "red/t/red/camera/raw", "red/t/base/map", "red/t/green/goal"}
    denied |= {"red/again/green/base/goal", "red/again/green/red/scan", "red/else", "green/hello", "green/to/base"}
    denied |= {"green/t/green/odom", "base/t/base/map", "base/hello", "red/**", "*/t/red/odom", "red/t/*/odom"}
    denied |= {"*/hello", "/pyros1/2/red/hello", "/elsewhere"}

    def ask(body: bytes) -> None:
        put_all(red, *denied, *allowed)(body)
        red.delete("red/t/red/odom")
        put_all(red, "red/hello")(body)

    assert base.heard("red/hello", ask) == allowed


@MODES
def test_a_site_that_may_take_some_topics_gets_nothing_else(
    port: int, make_station: Callable[..., Station], mode: str
) -> None:
    """Whatever it subscribes to."""
    access = access_of("{green: {take: [/cmd_vel, 'base:/map', '*:/odom'], deny_take: ['red:/odom']}, red: {}}")
    base = make_station("base", "router", access, listen=[f"tls/127.0.0.1:{port}"])
    red = make_station("red", connect=[f"tls/127.0.0.1:{port}"])
    spy = make_station("green", mode, connect=[f"tls/127.0.0.1:{port}"])
    allowed = {"base/to/green", "base/t/green/cmd_vel", "base/again/green/green/cmd_vel", "base/t/base/map"}
    allowed |= {"base/again/green/base/map", "base/t/base/odom"}
    denied = {"base/t/base/plan", "base/to/red", "base/t/red/cmd_vel", "base/t/red/odom", "base/again/red/base/map"}
    denied |= {"base/t/green/odom", "base/again/green/base/plan", "base/t/base/map/raw", "base/else"}
    assert spy.heard("base/hello", put_all(base, *denied, *allowed, "base/hello")) == allowed
    sent = {"red/t/red/odom", "red/t/green/cmd_vel", "red/again/green/red/odom", "red/t/red/map", "red/t/base/map"}
    assert spy.heard("red/hello", put_all(red, *sent, "red/hello")) == {"red/t/green/cmd_vel"}


@pytest.mark.slow
def test_a_connection_cannot_be_taken_over(keys: Path, port: int, make_station: Callable[..., Station]) -> None:
    """zenoh names connections by random numbers, which a site could learn and choose."""
    import zenoh

    base = make_station("base", "router", access_of("[red, green]"), listen=[f"tls/127.0.0.1:{port}"])
    red = make_station("red", connect=[f"tls/127.0.0.1:{port}"])
    assert base.heard("red/hello", put_all(red, "red/hello")) == set()
    for number in (red.session.zid(), base.session.zid()):
        settings = security_settings(load_keys(keys / "green"), ())
        config = make_config(zenoh, "client", [f"tls/127.0.0.1:{port}"], [], settings)
        config.insert_json5("id", json.dumps(str(number)))
        config.insert_json5("connect/timeout_ms", "1000")
        with pytest.raises(zenoh.ZError):
            zenoh.open(config)
        assert base.heard("red/hello", put_all(red, "red/hello")) == set()


def test_what_goes_into_the_names_of_a_site_is_only_for_it(port: int, make_station: Callable[..., Station]) -> None:
    base = make_station("base", "router", access_of("[red, green]"), listen=[f"tls/127.0.0.1:{port}"])
    spy = make_station("green", connect=[f"tls/127.0.0.1:{port}"])
    keys = {"base/t/red/cmd_vel", "base/again/red/base/map", "base/to/red", "base/t/green/cmd_vel", "base/t/base/map"}
    assert spy.heard("base/hello", put_all(base, *keys, "base/hello")) == {"base/t/green/cmd_vel", "base/t/base/map"}


def test_newer_keys_shut_the_older_ones_out(port: int, make_station: Callable[..., Station]) -> None:
    """Feature: keys of a site that are lost are shut out: `pyros1 bridge keys` makes others for it"""
    base = make_station("base", "router", access_of("[red-2, green]"), listen=[f"tls/127.0.0.1:{port}"])
    thief, red, green = (make_station(name, connect=[f"tls/127.0.0.1:{port}"]) for name in ("red", "red-2", "green"))

    def ask(body: bytes) -> None:
        put_all(thief, "red/t/red/odom", "red/to/base")(body)
        put_all(base, "base/to/red")(body)
        put_all(red, "red/hello")(body)

    for each in (base, green):
        assert each.heard("red/hello", ask) == set()
    assert red.heard("base/to/red", ask) == set()
    assert thief.heard_nothing()


def test_routers_in_a_row(free_ports: Callable[[int], list[int]], make_station: Callable[..., Station]) -> None:
    """A site behind another router writes only under its own name, as long as that router is honest; and that router
    can speak only for sites of which the file says that it forwards them.
    """
    to_base, to_hub = (f"tls/127.0.0.1:{port}" for port in free_ports(2))
    at_hub = access_of("{base: {forwards: [red, green]}, stranger: {}}")
    hub = make_station("hub", "router", at_hub, listen=[to_hub])
    at_base = access_of("{red: {}, green: {send: [/odom]}, hub: {forwards: [stranger]}}")
    base = make_station("base", "router", at_base, listen=[to_base], connect=[to_hub])
    red, green = (make_station(name, connect=[to_base]) for name in ("red", "green"))
    stranger = make_station("stranger", connect=[to_hub])

    def from_green(body: bytes) -> None:
        put_all(green, "red/hello", "base/hello", "stranger/hello", "green/t/green/scan", "green/t/green/odom")(body)
        put_all(green, "green/hello")(body)

    for each in (red, base, hub, stranger):
        assert each.heard("green/hello", from_green) == {"green/t/green/odom"}

    lies = put_all(stranger, "red/hello", "hub/hello", "base/hello", "stranger/hello")
    for each in (hub, base, red):
        assert each.heard("stranger/hello", lies) == set()

    broken_into = put_all(hub, "red/hello", "green/t/green/odom", "base/hello", "hub/to/red", "hub/hello")
    assert red.heard("hub/hello", broken_into) == {"hub/to/red"}
    assert base.heard("hub/hello", broken_into) == {"hub/to/red"}
    assert "stranger/hello" in red.heard("hub/hello", put_all(hub, "stranger/hello", "hub/hello"))  # it forwards it


def test_rules_for_many_sites_are_made_in_time() -> None:
    names = [f"site{number}" for number in range(256)]
    keys = SiteKeys("base", "base", Path(), Path(), Path(), datetime.now(timezone.utc))
    settings = security_settings(keys, [SiteAccess(name) for name in names], "base")
    assert len(settings["access_control"]) < 5 << 20


def test_nobody_else_is_this_site() -> None:
    keys = SiteKeys("base", "base", Path(), Path(), Path(), datetime.now(timezone.utc))
    access = access_of("{red: {forwards: [base, red]}, base: {}}")
    control = json.loads(security_settings(keys, access, "base")["access_control"])
    assert [(each["subjects"], each["rules"]) for each in control["policies"]] == [
        (["red"], ["subscribe", "red sends", "red takes"])
    ]
