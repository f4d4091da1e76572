"""Which services and parameters sites with keys may offer and call, on real connections."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from pyros1.bridge.protocol.key_expressions import parse_key
from pyros1.bridge.rules.services import PARAMETERS

from .stations import MODES, Station, access_of, put_all

pytest.importorskip("zenoh")
pytest.importorskip("cryptography")


@MODES
def test_a_site_that_may_serve_some_services_can_do_nothing_else(
    port: int, make_station: Callable[..., Station], mode: str
) -> None:
    """What it sends is replies, and what it gets is calls; those of its topics are limited, too."""
    sites = "{red: {serve: [/add, /arm/**], deny_serve: [/arm/off], send: [/odom]}, green: {}}"
    base = make_station("base", "router", access_of(sites), listen=[f"tls/127.0.0.1:{port}"])
    red = make_station("red", mode, connect=[f"tls/127.0.0.1:{port}"])
    green = make_station("green", connect=[f"tls/127.0.0.1:{port}"])
    allowed = {"red/call/base/red/add", "red/call/base/red/arm/on", "red/t/red/odom"}
    denied = {"red/call/base/red/other", "red/call/base/red/arm/off", "red/call/base/red/add/more"}
    denied |= {"red/call/base/base/add", "red/call/green/base/add", "red/call/green/green/add", "red/t/red/add"}
    denied |= {"red/again/base/red/add", f"red/call/base/red{PARAMETERS}", f"red/call/base/base{PARAMETERS}"}
    denied |= {"green/call/base/green/add", "red/call/**", "red/call/base/red/*", "red/call/base/*/add"}
    assert base.heard("red/hello", put_all(red, *denied, *allowed, "red/hello")) == allowed
    allowed = {"red/call/green/red/add"}
    denied = {"red/call/green/red/other", "red/call/green/red/arm/off", "red/call/base/red/add"}
    assert green.heard("red/hello", put_all(red, *denied, *allowed, "red/hello")) == allowed
    for name, caller in (("base", base), ("green", green)):
        allowed = {f"{name}/call/red/red/add", f"{name}/call/red/red/arm/on"}
        denied = {f"{name}/call/red/red/other", f"{name}/call/red/red/arm/off", f"{name}/call/red/{name}/add"}
        denied |= {f"{name}/call/red/red{PARAMETERS}", f"{name}/call/red/red/*", f"{name}/call/*/red/add"}
        denied |= {f"{name}/call/{other}/{other}/add" for other in ("base", "green") if other != name}
        denied |= {f"{name}/t/red/add", f"{name}/again/red/red/add", f"{name}/t/{name}/map"}
        assert red.heard(f"{name}/hello", put_all(caller, *denied, *allowed, f"{name}/hello")) == allowed


@MODES
def test_a_site_that_may_call_some_services_can_do_nothing_else(
    port: int, make_station: Callable[..., Station], mode: str
) -> None:
    sites = "{red: {call: ['base:/plan/**', '*:/ping'], deny_call: ['base:/plan/off']}, green: {}}"
    base = make_station("base", "router", access_of(sites), listen=[f"tls/127.0.0.1:{port}"])
    red = make_station("red", mode, connect=[f"tls/127.0.0.1:{port}"])
    green = make_station("green", connect=[f"tls/127.0.0.1:{port}"])
    allowed = {"red/call/base/base/plan/a", "red/call/base/base/ping", "red/call/green/green/ping"}
    denied = {"red/call/base/base/plan/off", "red/call/base/base/other", "red/call/green/green/plan/a"}
    denied |= {"red/call/green/base/ping", "red/call/base/green/ping", "red/call/base/red/ping", "red/call/*/base/ping"}
    denied |= {f"red/call/base/base{PARAMETERS}", "green/call/base/base/ping", "red/again/base/base/ping"}
    assert base.heard("red/hello", put_all(red, *denied, *allowed, "red/hello")) == allowed
    replies = {"base/call/red/base/plan/a", "base/call/red/base/ping"}
    others = {"base/call/red/base/plan/off", "base/call/red/base/other", "base/call/red/red/ping"}
    others |= {"base/call/green/base/ping", "base/call/red/green/ping", f"base/call/red/base{PARAMETERS}"}
    assert red.heard("base/hello", put_all(base, *replies, *others, "base/hello")) == replies
    replies = {"green/call/red/green/ping"}
    others = {"green/call/red/base/ping", "green/call/red/green/plan/a", "green/call/base/green/ping"}
    assert red.heard("green/hello", put_all(green, *replies, *others, "green/hello")) == replies


def test_services_and_parameters_need_a_word_of_their_own(port: int, make_station: Callable[..., Station]) -> None:
    """A site whose topics are limited has none; one that is denied some has the others, whatever wildcards it sends."""
    deny = f"deny_serve: [/off], deny_call: ['base:/off', 'base:{PARAMETERS}']"
    access = access_of(f"{{red: {{send: ['/**'], take: ['/**', 'base:**']}}, green: {{{deny}}}}}")
    base = make_station("base", "router", access, listen=[f"tls/127.0.0.1:{port}"])
    red, green = (make_station(name, connect=[f"tls/127.0.0.1:{port}"]) for name in ("red", "green"))
    calls = {f"red/call/base/{owner}{name}" for owner in ("red", "base") for name in ("/add", PARAMETERS)}
    assert base.heard("red/hello", put_all(red, *calls, "red/t/red/odom", "red/hello")) == {"red/t/red/odom"}
    calls = {f"base/call/red/{owner}{name}" for owner in ("red", "base") for name in ("/add", PARAMETERS)}
    assert red.heard("base/hello", put_all(base, *calls, "base/t/base/map", "base/hello")) == {"base/t/base/map"}
    allowed = {"green/call/base/base/add", "green/call/base/green/add", f"green/call/base/green{PARAMETERS}"}
    denied = {"green/call/base/base/off", "green/call/base/green/off", f"green/call/base/base{PARAMETERS}"}
    denied |= {"green/call/*/base/off", "green/call/base/*/off", "green/call/base/base/**", "green/call/**/off"}
    heard = base.heard("green/hello", put_all(green, *denied, *allowed, "green/hello"))
    parsed = [key for key in (parse_key(f"pyros1/1/{each}") for each in heard) if key is not None]
    # What arrives with wildcards in its key is for no site, or of no service.
    taken = {str(key.topic) for key in parsed if key.receiver == "base" and key.topic and key.topic.site != "*"}
    assert taken == {"base:/add", "green:/add", f"green:{PARAMETERS}"}
    answers = {"base/call/green/base/add", "base/call/green/green/add"}
    others = {"base/call/green/base/off", "base/call/green/green/off", f"base/call/green/base{PARAMETERS}"}
    assert green.heard("base/hello", put_all(base, *answers, *others, "base/hello")) == answers
