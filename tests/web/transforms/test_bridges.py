"""What pages show of a bridge."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.web.transforms.bridges import describe_bridge

SENT = {
    "local": "/cmd_vel",
    "wanted_by": ["red", "blue"],
    "messages_per_second": 10.0,
    "bytes_per_second": 480.0,
    "dropped": {},
}
RECEIVED = {
    "local": "/red/odom",
    "from": "red",
    "state": "subscribed",
    "messages_per_second": None,
    "bytes_per_second": None,
    "dropped": {"too old": 3, "repeated": 4},
}
STATUS: dict[str, Any] = {
    "site": "base",
    "link": "",
    "sites": [
        {"name": "red", "state": "present", "round_trip": 0.01, "nodes": ["/red/driver"]},
        {"name": "blue", "state": "lost", "round_trip": None},
    ],
    "sent": [SENT],
    "received": [
        RECEIVED,
        {**RECEIVED, "local": "/red/map", "state": "no subscribers here"},
        {**RECEIVED, "local": "", "state": "no rule takes it"},
        {**RECEIVED, "local": "/blue/map", "from": "blue", "state": "site lost"},
    ],
}


def test_a_bridge() -> None:
    found = describe_bridge("/bridge_base", STATUS)
    assert found is not None
    assert (found["node"], found["site"], found["link"]) == ("/bridge_base", "base", "")
    assert found["sites"] == [
        {"name": "red", "state": "present", "round_trip": 0.01, "nodes": ["/red/driver"]},
        {"name": "blue", "state": "lost", "round_trip": None, "nodes": []},
    ]
    flows = [(flow["topic"], flow["site"], flow["out"], flow["wanted"]) for flow in found["flows"]]
    assert flows == [
        ("/cmd_vel", "red", True, True),
        ("/cmd_vel", "blue", True, True),
        ("/red/odom", "red", False, True),
        ("/red/map", "red", False, False),
        ("/blue/map", "blue", False, True),
    ]
    assert (found["flows"][0]["hz"], found["flows"][0]["bytes"]) == (10.0, 480.0)
    assert found["flows"][2]["dropped"] == {"too old": 3}


def test_names_that_are_too_long_are_cut() -> None:
    found = describe_bridge("/b", {**STATUS, "site": 1000 * "x", "sent": [], "received": [], "sites": []})
    assert found is not None and len(found["site"]) == 300


@pytest.mark.parametrize(
    "changes",
    [
        {"sites": 5},
        {"sites": [{}]},
        {"site": None},
        {"sent": [{**SENT, "wanted_by": 5}]},
        {"sent": [{**SENT, "messages_per_second": "many"}]},
        {"sent": [{**SENT, "messages_per_second": float("nan")}]},
        {"received": [{**RECEIVED, "dropped": []}]},
        {"received": [{**RECEIVED, "dropped": {"too old": "<b>"}}]},
    ],
)
def test_what_cannot_be_read(changes: dict[str, Any]) -> None:
    assert describe_bridge("/b", {**STATUS, **changes}) is None


ANY = st.recursive(
    st.none() | st.integers() | st.text(max_size=4),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from([*RECEIVED, *SENT]), inner),
    max_leaves=20,
)


@pytest.mark.slow
@given(st.fixed_dictionaries(dict.fromkeys(STATUS, ANY)))
def test_any_status_is_read_or_not(status: dict[str, Any]) -> None:
    assert describe_bridge("/b", status) is None or True
