"""Describes bridges for pages. A bridge's status comes from another program, and may contain anything (no I/O)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from math import isfinite
from typing import Any

from pyros1.doctor.bridge_checks import DROPS

_MAX_SITES = 100
_MAX_NODES = 200
_MAX_FLOWS = 1_000
_MAX_TEXT = 300


def describe_bridge(node: str, status: Mapping[str, Any]) -> dict[str, Any] | None:
    """Return a bridge as JSON; None if its status cannot be read.

    Args:
        node: the name of the bridge's node.
        status: the bridge's status.

    Returns:
        - node, site: the node, and the name of the site that it belongs to
        - link: why the bridge has no connection; empty if it has one
        - sites: other sites, each with name, state, round_trip in seconds or null, and nodes: local nodes that
          represent nodes of the site
        - flows: exchanged topics, each with topic (its local name), site, out (whether it is sent to the site), wanted
          (whether it has subscribers), hz and bytes per second or null, and dropped: the number of dropped messages for
          each reason that is a problem
    """
    try:
        sites = [_site(each) for each in status["sites"][:_MAX_SITES]]
        lost = {each["name"] for each in sites if each["state"] != "present"}
        flows = [*_sent_flows(status["sent"]), *_received_flows(status["received"], lost)]
        site, link = _text(status["site"]), _text(status["link"])
    except (KeyError, TypeError, ValueError, AttributeError):
        return None
    return {"node": node, "site": site, "link": link, "sites": sites, "flows": flows[:_MAX_FLOWS]}


def _site(entry: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "name": _text(entry["name"]),
        "state": _text(entry["state"]),
        "round_trip": _number(entry["round_trip"]),
        "nodes": [_text(name) for name in entry.get("nodes", [])[:_MAX_NODES]],
    }


def _sent_flows(entries: Iterable[Mapping[str, Any]]) -> Iterable[dict[str, Any]]:
    for entry in entries:
        for site in entry["wanted_by"][:_MAX_SITES]:
            yield _flow(entry, site, True, True)


def _received_flows(entries: Iterable[Mapping[str, Any]], lost: set[str]) -> Iterable[dict[str, Any]]:
    for entry in entries:
        if entry["local"]:
            is_wanted = entry["state"] == "subscribed" or _text(entry["from"]) in lost
            yield _flow(entry, entry["from"], False, is_wanted)


def _flow(entry: Mapping[str, Any], site: object, out: bool, is_wanted: bool) -> dict[str, Any]:
    return {
        "topic": _text(entry["local"]),
        "site": _text(site),
        "out": out,
        "wanted": is_wanted,
        "hz": _number(entry.get("messages_per_second")),
        "bytes": _number(entry.get("bytes_per_second")),
        "dropped": {
            reason: number for reason, number in entry["dropped"].items() if reason in DROPS and _number(number)
        },
    }


def _text(value: object) -> str:
    if not isinstance(value, str):
        raise TypeError("not a string")
    return value[:_MAX_TEXT]


def _number(value: object) -> float | None:
    if value is None:
        return None
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not isfinite(value):
        raise TypeError("not a number")
    return value
