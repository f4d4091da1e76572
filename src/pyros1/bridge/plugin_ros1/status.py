"""The status of a zenoh-plugin-ros1 bridge, as JSON in the format of `pyros1.bridge.status`: namespaces are sites."""

from __future__ import annotations

import json
from collections.abc import Mapping

from pyros1.bridge.plugin_ros1.keys import ANY, DIALECT, Kind
from pyros1.bridge.plugin_ros1.services import PluginServices
from pyros1.bridge.plugin_ros1.session import PluginSession
from pyros1.bridge.plugin_ros1.state import PluginState
from pyros1.bridge.transport.sender import Sender

_MAX_REFUSED = 50
"""Maximum number of refused topics to list."""


def status_json(
    state: PluginState,
    session: PluginSession,
    sender: Sender,
    services: PluginServices,
    problems: Mapping[str, str],
    trouble: Mapping[str, int],
    dropped: int,
) -> str:
    """Return the status as JSON.

    Args:
        state, session, sender, services: the parts of the bridge.
        problems: topic or service -> why it is not bridged.
        trouble: description of a problem -> how often it has occurred.
        dropped: how many messages and beacons were dropped because they came too fast.
    """
    plan, rules = state.plan, state.rules
    namespaces = sorted({resource.namespace for resource in state.heard.used})
    received = [
        {
            "topic": " ".join(map(str, taken.sources)),
            "from": _names(sorted({source.namespace for source in taken.sources})),
            "local": local,
            "type": taken.type,
            "state": "subscribed" if local in state.subscribed else "nobody here subscribes",
            "messages": state.taken[local].messages,
            "bytes": state.taken[local].bytes,
            "dropped": state.taken[local].drops,
        }
        for local, taken in plan.takes.items()
    ]
    refused: list[dict[str, object]] = [
        {
            "topic": str(resource),
            "from": _names([resource.namespace]),
            "local": "",
            "type": resource.type,
            "state": f"{rules.incoming(resource)}{' (a service)' * (resource.kind is Kind.SERVICE)}",
            "messages": 0,
            "bytes": 0,
            "dropped": {},
        }
        for resource in state.heard.unused[:_MAX_REFUSED]
    ]
    status = {
        "dialect": DIALECT,
        "site": rules.namespace,
        "link": session.problem,
        "sites": [{"name": _names([name]), "state": "present", "round_trip": None} for name in namespaces],
        "sent": [
            {
                "topic": str(resource),
                "local": sent.local.name,
                "type": resource.type,
                "publishers": [*sent.local.publishers],
                "wanted_by": [_names([resource.namespace])] if resource in state.wanted else [],
                "messages": state.sent[resource].messages,
                "bytes": state.sent[resource].bytes,
                "dropped": _add(state.sent[resource].drops, sender.drops(state.key(resource))),
            }
            for resource, sent in plan.sends.items()
        ],
        "received": received + refused,
        "plugin_services": [
            *(_service(services, "serves", local, str(resource)) for resource, local in plan.serves.items()),
            *(_service(services, "calls", local, str(taken.sources[0])) for local, taken in plan.calls.items()),
        ],
        "waiting_bytes": sender.waiting_bytes,
        "overflowed": dropped,
        "ignored": _add(state.heard.ignored, state.ignored),
        "problems": {**plan.problems, **problems},
        "trouble": dict(trouble),
    }
    return json.dumps(status)


def _names(namespaces: list[str]) -> str:
    return " ".join("bridges without a namespace" if name == ANY else name for name in namespaces)


def _service(services: PluginServices, kind: str, local: str, name: str) -> dict[str, object]:
    count = services.count(kind, local)
    return {
        "kind": kind,
        "local": local,
        "service": name,
        "calls": count.calls,
        "errors": count.errors,
        "last_error": count.last_error,
        "note": count.note,
    }


def _add(first: Mapping[str, int], second: Mapping[str, int]) -> dict[str, int]:
    return {reason: first.get(reason, 0) + second.get(reason, 0) for reason in (*first, *second)}
