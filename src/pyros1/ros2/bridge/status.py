"""The status of a bridge to ROS 2, as JSON, in the form of `pyros1.bridge.status`: ROS 2 is its only other site."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from itertools import islice
from typing import Any

from pyros1 import __version__
from pyros1.bridge.exchange.services.call_packets import CallCounts
from pyros1.bridge.status import ROS2, listed, rate_cells
from pyros1.bridge.transport.sender import Sender
from pyros1.ros2.bridge.counts import Counts
from pyros1.ros2.bridge.plan import Plan
from pyros1.ros2.bridge.services import Ros2Services

OTHER_SITE = "ROS 2"
_MAX_NODES = 1000
MAX_PROBLEMS = 5000
"""Maximum number of topics and services that are listed with their problems."""


def status_json(
    way: str,
    domain: int,
    plan: Plan,
    nodes: Collection[str],
    subscribed: Collection[str],
    link_problem: str,
    sender: Sender,
    problems: Mapping[str, str],
    counts: Counts,
    services: Ros2Services,
    actions: list[dict[str, str]],
    trouble: Mapping[str, int],
    dropped: int,
) -> str:
    """Return the status as JSON.

    Args:
        way: how the bridge connects to ROS 2, see `pyros1.ros2.bridge.side.Ros2Side`.
        domain: the ROS domain.
        plan: the topics to exchange.
        nodes: the full names of the nodes in ROS 2.
        subscribed: the ROS 2 topics that ROS 1 nodes subscribe to.
        link_problem: why there is no connection; empty if there is one.
        sender: the queue of messages to send.
        problems: topic or service -> why it is not exchanged.
        counts: the counts and rates of messages.
        services: the services of both sides.
        actions: the actions of both sides.
        trouble: description of a problem -> how often it has occurred.
        dropped: how many messages were dropped because they came too fast.
    """
    entries: list[tuple[bool, dict[str, Any]]] = [(True, each) for each in _received(plan, subscribed, counts)]
    entries += [(False, each) for each in _called(services)]
    entries, more = listed(entries, lambda _: OTHER_SITE, _size)
    named = dict(islice(problems.items(), MAX_PROBLEMS))
    if len(named) < len(problems):
        trouble = {**trouble, "topics and services with problems that are not listed": len(problems) - len(named)}
    status = {
        "dialect": ROS2,
        "via": way,
        "site": "ROS 1",
        "version": __version__,
        "domain": domain,
        "link": link_problem,
        "sites": [{"name": OTHER_SITE, "state": "present", "round_trip": None}] if nodes else [],
        "ros2_nodes": sorted(nodes)[:_MAX_NODES],
        "sent": [
            {
                "topic": key.name,
                "local": announced.local.name,
                "type": announced.pair.ros2,
                "publishers": [*announced.local.publishers],
                "wanted_by": [OTHER_SITE] if announced.is_subscribed else [],
                "messages": counts.to_ros2(announced.local.name).messages,
                "bytes": counts.to_ros2(announced.local.name).bytes,
                **rate_cells(counts.rate_to_ros2(announced.local.name)),
                "dropped": _drops(counts.to_ros2(announced.local.name).drops, sender, announced.routes(key)),
            }
            for key, announced in plan.announces.items()
        ],
        "received": [entry for is_topic, entry in entries if is_topic],
        "served": [
            {
                "service": name,
                "local": name,
                "type": type_name,
                **_call_cells(services.counts("served", name)),
            }
            for name, type_name in {
                key.name: offered.pair.ros1 for key, offered in services.plan.offers.items()
            }.items()
        ],
        "called": [entry for is_topic, entry in entries if not is_topic],
        "not_listed": more,
        "actions": actions,
        "waiting_bytes": sender.waiting_bytes,
        "overflowed": dropped,
        "ignored": {},
        "problems": named,
        "trouble": dict(trouble),
    }
    return json.dumps(status)


def _received(plan: Plan, subscribed: Collection[str], counts: Counts) -> Iterator[dict[str, Any]]:
    for topic, taken in plan.takes.items():
        flow = counts.to_ros1(topic)
        yield {
            "topic": topic,
            "from": OTHER_SITE,
            "local": topic,
            "type": taken.pair.ros1,
            "publishers": [*taken.publishers],
            "state": "subscribed" if topic in subscribed else "nobody here subscribes",
            "messages": flow.messages,
            "bytes": flow.bytes,
            **rate_cells(counts.rate_to_ros1(topic)),
            "dropped": flow.drops,
        }


def _called(services: Ros2Services) -> Iterator[dict[str, Any]]:
    for name, provided in services.plan.provides.items():
        yield {
            "service": name,
            "from": OTHER_SITE,
            "local": name,
            "type": provided.pair.ros1,
            "state": "",
            **_call_cells(services.counts("called", name)),
        }


def _size(entry: tuple[bool, dict[str, Any]]) -> int:
    """Return the approximate size of an entry in bytes."""
    return 300 + len(str(entry))


def _call_cells(counts: CallCounts) -> dict[str, int | str]:
    return {"calls": counts.calls, "errors": counts.errors, "last_error": counts.last_error}


def _drops(first: Mapping[str, int], sender: Sender, routes: Collection[str]) -> dict[str, int]:
    total = Counter(first)
    for route in routes:
        total.update(sender.drops(route))
    return dict(total)
