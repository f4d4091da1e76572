"""The status of a bridge: as JSON, which its service returns, and as lines of text."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping
from typing import Any, TypeVar

from pyros1 import __version__
from pyros1.bridge.exchange.incoming import ReceivedTopic
from pyros1.bridge.exchange.outgoing import OutgoingTopic
from pyros1.bridge.exchange.services.call_packets import CallCounts
from pyros1.bridge.exchange.services.calls import RemoteService
from pyros1.bridge.exchange.site import Site
from pyros1.bridge.exchange.topic_sender import TopicCounts
from pyros1.bridge.protocol.key_expressions import direct_topic_key, topic_key
from pyros1.bridge.rates import Count, Rate, Rates
from pyros1.bridge.rules.services import PARAMETERS
from pyros1.bridge.transport.inbox import Inbox
from pyros1.bridge.transport.link import Link
from pyros1.bridge.transport.sender import Sender
from pyros1.ground.terminal_text import one_line

LISTED_BYTES = 3 << 20
"""Approximate maximum size in bytes of the list of other sites' topics, and of the list of their services: readers
accept only a few megabytes.
"""
_NAMED = 3
"""Maximum number of a site's refused topics or services to name for each reason."""
_Entry = TypeVar("_Entry")


def status_json(
    site: Site,
    link: Link,
    sender: Sender,
    inbox: Inbox,
    rates: Rates,
    problems: Mapping[str, str],
    trouble: Mapping[str, int],
) -> str:
    """Return the status as JSON.

    Args:
        site, link, sender, inbox, rates: the parts of the bridge.
        problems: topic -> why it cannot be sent.
        trouble: description of a problem -> how often it has occurred.
    """
    received, more_topics = listed(site.received_topics(), lambda each: each.peer, _received_size)
    called, more_services = listed(site.services.calls.services(), lambda each: each.peer, _called_size)
    status = {
        "site": site.name,
        "version": __version__,
        "link": link.problem,
        "sites": [
            {
                "name": each.name,
                "state": each.state.value,
                "round_trip": each.round_trip,
                "nodes": each.nodes,
                "slow": each.is_slow,
                "shared": each.is_shared,
            }
            for each in site.sites()
        ],
        "sent": [
            {
                "topic": str(topic.topic),
                "local": local.name,
                "conversion": local.conversion.kind if local.conversion else "",
                "type": topic.offered.type,
                "publishers": [*local.publishers],
                "wanted_by": sorted(topic.requests),
                "messages": flow.messages,
                "bytes": flow.bytes,
                **rate_cells(rates.rate(("", topic.topic))),
                "dropped": _add(flow.drops, *(sender.drops(key) for key in _keys(topic))),
            }
            for topic, local, flow in site.sent_topics()
        ],
        "received": [
            {
                "topic": str(topic.topic),
                "from": topic.peer,
                "local": topic.local,
                "usual": site.default_name(topic.topic),
                "type": topic.type,
                "publishers": [*topic.publishers],
                "state": topic.state,
                "messages": topic.flow.messages,
                "bytes": topic.flow.bytes,
                **rate_cells(rates.rate((topic.peer, topic.topic))),
                "dropped": _add(topic.flow.drops, topic.missed_drops),
            }
            for topic in received
        ],
        "served": [
            {
                "service": str(service.offered.service),
                "local": service.local,
                "type": service.offered.type,
                **_call_cells(service.counts),
            }
            for service in site.services.served.services()
        ],
        "called": [
            {
                "service": str(service.offered.service),
                "from": service.peer,
                "local": service.local,
                "type": service.offered.type,
                "state": service.state,
                **_call_cells(service.counts),
            }
            for service in called
        ],
        "not_listed": _add(more_topics, more_services),
        "waiting_bytes": sender.waiting_bytes,
        "overflowed": inbox.dropped,
        "ignored": site.ignored,
        "problems": dict(problems),
        "trouble": dict(trouble),
    }
    return json.dumps(status)


def listed(
    entries: Iterable[_Entry], site_of: Callable[[_Entry], str], size_of: Callable[[_Entry], int]
) -> tuple[list[_Entry], dict[str, int]]:
    """Return the entries of other sites to list, and how many more each site has. If all together exceed
    `LISTED_BYTES`, the lists of the sites with the most bytes are cut, so that no site hides others.

    Args:
        entries: all entries.
        site_of: returns an entry's site.
        size_of: returns its approximate size in bytes.
    """
    sizes: Counter[str] = Counter()
    for entry in (all_entries := [*entries]):
        sizes[site_of(entry)] += size_of(entry)
    left, share = LISTED_BYTES, 0
    for place, size in enumerate(sorted(sizes.values())):
        share = left // (len(sizes) - place)
        if size > share:
            break
        left -= size
    else:
        return all_entries, {}
    used: Counter[str] = Counter()
    more: Counter[str] = Counter()
    found = []
    for entry in all_entries:
        site = site_of(entry)
        used[site] += size_of(entry)
        if used[site] <= share:
            found.append(entry)
        else:
            more[site] += 1
    return found, dict(more)


def _received_size(topic: ReceivedTopic) -> int:
    names = (*topic.topic, *topic.topic, topic.type, topic.local, topic.state, *topic.publishers)
    return 300 + sum(map(len, names))


def _called_size(service: RemoteService) -> int:
    return 200 + sum(map(len, (*service.offered.service, service.offered.type, service.local, service.state)))


def flow_counts(site: Site) -> dict[Hashable, Count]:
    """Return how much of each topic has been sent or received, for the rates in the status. Topics without messages are
    left out, since this is called each second and there may be thousands of topics.
    """
    flows: list[tuple[Hashable, TopicCounts]] = [(("", topic.topic), flow) for topic, _, flow in site.sent_topics()]
    flows += site.topic_receiver.flows()
    return {key: Count(flow.messages, flow.bytes) for key, flow in flows if flow.messages}


def rate_cells(rate: Rate | None) -> dict[str, float | None]:
    """Return the fields of a topic's entry that contain its rate."""
    return {
        "messages_per_second": None if rate is None else round(rate.messages, 2),
        "bytes_per_second": None if rate is None else round(rate.bytes, 1),
    }


def _call_cells(counts: CallCounts) -> dict[str, Any]:
    return {"calls": counts.calls, "errors": counts.errors, "last_error": counts.last_error}


def _keys(topic: OutgoingTopic) -> list[str]:
    return [topic_key(topic.topic), *(direct_topic_key(peer, topic.topic) for peer in topic.requests)]


def _add(*drops: Mapping[str, int]) -> dict[str, int]:
    total: Counter[str] = Counter()
    for each in drops:
        total.update(each)
    return dict(total)


ROS2 = "ros2"
"""The dialect in the status of a bridge to ROS 2."""


def status_lines(status: Mapping[str, Any]) -> Iterator[str]:
    """Yield lines that describe a status.

    Args:
        status: a status from `status_json`; it comes from another program, so it may contain any names.
    """
    dialect, name = status.get("dialect"), one_line(status["site"])
    if dialect == ROS2:
        yield f"bridge to ROS 2 through {one_line(status.get('via', 'zenoh'))}, domain {one_line(status['domain'])}"
    elif dialect:
        where = "without a namespace" if name == "*" else f"in namespace {name}"
        yield f"bridge of {one_line(dialect)}, {where}"
    else:
        yield f"site {name}"
    if status["link"]:
        yield f"  no connection: {one_line(status['link'])}"
    for site in status["sites"] if dialect != ROS2 else ():
        trip = site["round_trip"]
        yield (
            f"  {one_line(site['name'])}: {one_line(site['state'])}"
            + (f", round trip {trip * 1000:.1f} ms" if trip is not None else "")
            + (", slower than others: gets its own packets" if site.get("slow") else "")
            + (", but two bridges use this name" if site.get("shared") else "")
        )
    if nodes := [one_line(node) for node in status.get("ros2_nodes", ())]:
        more = len(nodes) - _NAMED
        yield f"  nodes: {' '.join(nodes[:_NAMED])}" + (f" and {more} more" if more > 0 else "")
    elif dialect == ROS2:
        yield "  no ROS 2 nodes found"
    elif not status["sites"]:
        yield "  no topics or services that are taken found yet" if dialect else "  no other site found yet"
    yield from _table("sends", status["sent"], _sent_cells)
    yield from _table("takes", [entry for entry in status["received"] if entry["local"]], _received_cells)
    refused = [entry for entry in status["received"] if not entry["local"]]
    yield from _refused_lines("not taken", "topics", refused, "topic")
    yield from _not_listed(status)
    called = status.get("called", ())
    yield from _service_lines("lets others call", [(each, "") for each in status.get("served", ())])
    yield from _service_lines(
        "provides services of others",
        [(each, f"from {one_line(each['from'])}") for each in called if not each["state"]],
    )
    yield from _refused_lines("not provided", "services", [each for each in called if each["state"]], "service")
    yield from _plugin_services(status.get("plugin_services", ()))
    yield from _action_lines(status.get("actions", ()))
    for topic, problem in status["problems"].items():
        yield f"  {one_line(topic)}: {one_line(problem)}"
    if status["overflowed"]:
        yield f"  {status['overflowed']} packets dropped, since they came faster than they could be handled"
    for label, counts in (("ignored", status["ignored"]), ("problem", status["trouble"])):
        for reason, number in counts.items():
            yield f"  {label}: {one_line(reason)} ({number} time{'s' * (number != 1)})"


def _refused_lines(title: str, what: str, entries: Iterable[Mapping[str, Any]], field: str) -> Iterator[str]:
    """Yield a line for each site and reason, with only the first names, since there may be hundreds."""
    groups: dict[tuple[str, str], list[str]] = {}
    for entry in entries:
        groups.setdefault((one_line(entry["from"]), one_line(entry["state"])), []).append(one_line(entry[field]))
    for (site, reason), names in groups.items():
        more = len(names) - _NAMED
        listed_names = " ".join(names[:_NAMED]) + (f" and {more} more {what}" if more > 0 else "")
        yield f"  {title}: {listed_names} from {site}: {reason}"


def _not_listed(status: Mapping[str, Any]) -> Iterator[str]:
    for name, number in status.get("not_listed", {}).items():  # older bridges do not report it
        yield f"  {number} more topics and services of {one_line(name)} are not listed"


def _sent_cells(entry: Mapping[str, Any]) -> list[str]:
    wanted = " ".join(entry["wanted_by"])
    conversion = entry.get("conversion")  # older bridges do not report it
    name = one_line(entry["local"]) + (f" ({one_line(conversion)})" if conversion else "")
    return [name, f"to {one_line(wanted)}" if wanted else "no subscribers"]


def _received_cells(entry: Mapping[str, Any]) -> list[str]:
    return [one_line(entry["local"]), f"from {one_line(entry['from'])}: {one_line(entry['state'])}"]


def _service_lines(title: str, entries: list[tuple[Any, str]]) -> Iterator[str]:
    if entries:
        yield f"{title}:"
    names = ["parameters" if entry["local"] == PARAMETERS else one_line(entry["local"]) for entry, _ in entries]
    widths = [max(map(len, column), default=0) for column in (names, [origin for _, origin in entries])]
    for name, (entry, origin) in zip(names, entries, strict=True):
        calls, errors = entry["calls"], entry["errors"]
        text = f"  {name:{widths[0]}}  {origin:{widths[1]}}{'  ' * bool(origin)}{calls} call{'s' * (calls != 1)}"
        if errors:
            text += f", {errors} error{'s' * (errors != 1)}, the last: {one_line(entry['last_error'])}"
        yield text


def _action_lines(actions: Iterable[Mapping[str, Any]]) -> Iterator[str]:
    for number, each in enumerate(actions):
        if not number:
            yield "  actions:"
        where = f"server {one_line(each['node'])} in {one_line(each['server'])}"
        yield f"    {one_line(each['action'])} ({one_line(each['type'])}): {where}"


def _plugin_services(services: Iterable[Mapping[str, Any]]) -> Iterator[str]:
    for entry in services:
        calls, errors = entry["calls"], entry["errors"]
        last = f", the last one: {one_line(entry['last_error'], 200)}" if errors else ""
        yield (
            f"  {one_line(entry['kind'])} {one_line(entry['local'])} as {one_line(entry['service'])}: "
            f"{calls} call{'s' * (calls != 1)}, {errors} error{'s' * (errors != 1)}{last}"
            + (f" ({one_line(entry['note'])})" if entry["note"] else "")
        )


def _table(title: str, entries: list[Any], cells: Any) -> Iterator[str]:
    if not entries:
        return
    yield f"{title}:"
    rows = []
    for entry in entries:
        drops = ", ".join(f"{number} {one_line(reason)}" for reason, number in entry["dropped"].items())
        count = entry["messages"]
        flow = f"{count} message{'s' * (count != 1)}, {_size(entry['bytes'])}{_rate_text(entry)}"
        rows.append([*cells(entry), flow + (f"; dropped: {drops}" if drops else "")])
    widths = [max(len(row[column]) for row in rows) for column in range(2)]
    for row in rows:
        yield f"  {row[0]:{widths[0]}}  {row[1]:{widths[1]}}  {row[2]}"


def _rate_text(entry: Mapping[str, Any]) -> str:
    rate = entry.get("messages_per_second")
    return f", now {rate:.4g} Hz, {_size(entry['bytes_per_second'])}/s" if rate else ""


def _size(number: float) -> str:
    for unit in ("B", "kB", "MB"):
        if number < 1000:
            return f"{number:.0f} {unit}" if unit == "B" else f"{number:.1f} {unit}"
        number /= 1000
    return f"{number:.1f} GB"
