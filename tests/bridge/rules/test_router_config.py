"""The file of a router alone."""

from __future__ import annotations

import pytest

from pyros1.bridge.rules.file_reader import RulesError
from pyros1.bridge.rules.router_config import RouterConfig, explain_router, parse_router_config

FILE = """
listen: tls/[::]:7447
to: [tls/hub.example:7447]
keys: router
sites:
  red:
    {send: [/odom, /scan], take: [/cmd_vel], deny_send: [/scan/raw],
     serve: [/set_map], call: [base:/plan, '*:/ping'], deny_call: [far:/ping]}
  blue-2:
  dumb: {send: []}
  hub: {forwards: [far, farther], deny_take: [far:/secret]}
"""


def test_a_file() -> None:
    config = parse_router_config(FILE, "f")
    assert (config.listen, config.connect, config.keys) == (("tls/[::]:7447",), ("tls/hub.example:7447",), "router")
    assert [*explain_router(config)] == [
        "a router for red, blue, dumb, hub, far, farther",
        "  connects to tls/hub.example:7447",
        "  listens on tls/[::]:7447",
        "  proves its name with the keys in router, and requires certificates from others",
        "  red may send /odom, /scan, but not /scan/raw",
        "  red may take /cmd_vel",
        "  red may serve /set_map",
        "  red may call base:/plan, *:/ping, but not far:/ping",
        "  accepts only the keys of blue that are named blue-2",
        "  dumb may send nothing",
        "  dumb may take nothing",
        "  dumb may serve nothing",
        "  dumb may call nothing",
        "  hub may take everything, but not far:/secret",
        "  hub forwards packets from and to far, farther",
    ]
    assert [*explain_router(RouterConfig())] == ["a router for all sites"]
    assert parse_router_config("", "f") == RouterConfig()


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("site: red", "f.yaml:1: there is no setting 'site'"),
        ("send: [/odom]", "f.yaml:1: there is no setting 'send'"),
        ("listen: 7447", "f.yaml:1: expected a string"),
        ("to:\n- tls/hub", "f.yaml:2: 'tls/hub' is not an endpoint"),
        ("keys: []", "f.yaml:1: expected a string"),
        ("- a", "f.yaml:1: expected a mapping"),
    ],
)
def test_mistakes(text: str, complaint: str) -> None:
    with pytest.raises(RulesError) as caught:
        parse_router_config(text, "f.yaml")
    assert str(caught.value).startswith(complaint)
