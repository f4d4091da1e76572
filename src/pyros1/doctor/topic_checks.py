"""Checks of a running system: topics with one end, mismatched types, missing connections. Pure."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping

from pyros1.doctor.edges import Edge, actual_edges, expected_edges, is_lacking
from pyros1.doctor.facts import End, Offer, System
from pyros1.doctor.finding import ERROR, WARNING, Finding
from pyros1.graph import Connection

_NO_MATTER = frozenset({"/clock", "/rosout", "/statistics", "/tf_static"})
"""Topics that may have one end only."""
_NEAR = 0.75


def check_topics(system: System) -> list[Finding]:
    """Return the problems with the topics of a system."""
    checks = (_clock, _types, _odd_ends, _unheard, _links)
    return [finding for check in checks for finding in check(system)]


def _clock(system: System) -> Iterator[Finding]:
    publishers = system.state.publishers.get("/clock", [])
    alive = [name for name in publishers if name in system.nodes and system.nodes[name].failure is None]
    if system.use_sim_time and not alive:
        yield Finding(
            "no-clock",
            ERROR,
            "/use_sim_time is true, but no node publishes /clock: time stays at 0 in all nodes",
            "start the simulator (or `rosbag play --clock`), or: pyros1 param set /use_sim_time false, and restart the "
            "nodes",
        )
    elif alive and not system.use_sim_time:
        yield Finding(
            "unused-clock",
            WARNING,
            "/clock is published, but /use_sim_time is not true: nodes run on the wall clock",
            "pyros1 param set /use_sim_time true, before the nodes start",
            tuple(alive),
        )


def _types(system: System) -> Iterator[Finding]:
    for topic in sorted({end.topic for end in (*system.publications, *system.subscriptions)}):
        offers = {f"publisher {end.node}": offer for end, offer in _known(system.publications, topic)}
        offers |= {f"subscriber {end.node}": offer for end, offer in _known(system.subscriptions, topic)}
        types = {offer.type for offer in offers.values()} - {"*"}
        md5sums = {offer.md5sum for offer in offers.values()} - {"*"}
        if len(types) > 1:
            yield Finding(
                "type-mismatch",
                ERROR,
                f"the nodes of topic {topic} do not agree on its type: {', '.join(map(str, sorted(types)))}",
                "correct the type in one of them, or remap one to another topic: they cannot connect",
                tuple(f"{who}: {offer.type}" for who, offer in offers.items()),
            )
        elif len(md5sums) > 1:
            name = next(iter(types), "*")
            yield Finding(
                "md5-mismatch",
                ERROR,
                f"the nodes of topic {topic} have different definitions of {name}",
                f"compare `pyros1 msg md5 {name}` on their machines, rebuild the older package, and restart its nodes",
                tuple(f"{who}: {offer.md5sum}" for who, offer in offers.items()),
            )


def _odd_ends(system: System) -> Iterator[Finding]:
    """Check for publishers whose messages do not end where they should."""
    odd = [(end, offer) for end, offer in sorted(system.publications.items()) if offer.surplus]
    if odd:
        yield Finding(
            "odd-ends",
            WARNING,
            "The messages of the following publishers are longer or shorter than their type; subscribers accept them:",
            "compare the definition of the type there with `pyros1 msg show` here; boards with an old library of "
            "rosserial send a checksum byte: update it",
            tuple(f"{end.node}: {end.topic} ({offer.type}): {_end_text(offer.surplus)}" for end, offer in odd),
        )


def _end_text(surplus: int) -> str:
    many = f"{abs(surplus)} byte{'s' * (abs(surplus) != 1)}"
    return f"{many} too many" if surplus > 0 else f"{many} missing"


def _known(offers: Mapping[End, Offer], topic: str) -> list[tuple[End, Offer]]:
    return [(end, offer) for end, offer in sorted(offers.items()) if end.topic == topic and offer.failure is None]


def _unheard(system: System) -> Iterator[Finding]:
    """Check for topics that are subscribed but not published, and for similar names."""
    state = system.state
    near: list[str] = []
    plain: list[str] = []
    for topic, nodes in sorted(state.subscribers.items()):
        if state.publishers.get(topic) or topic in _NO_MATTER:
            continue
        other = near_miss(topic, [name for name in state.publishers if name not in _NO_MATTER])
        for node in nodes:
            if other is None:
                plain.append(f"{node}: {topic}")
            else:
                near.append(
                    f"{node} subscribes to {topic}; {', '.join(map(str, state.publishers[other]))} publishes {other}"
                )
    if near:
        yield Finding(
            "near-miss",
            WARNING,
            "The following topics have no publisher, but a topic of a similar name has:",
            "correct the name, or remap: FROM:=TO on the command line, <remap from= to=> in the launch file",
            tuple(near),
        )
    if plain:
        yield Finding(
            "no-publisher",
            WARNING,
            "The following node subscriptions are unconnected: no node publishes their topics",
            "start the nodes that publish them; if they are running, compare the names: pyros1 topic list -v",
            tuple(plain),
        )


def near_miss(topic: str, others: list[str]) -> str | None:
    """Return a topic with a similar name, or the same name in another namespace, None if there is none."""
    last = topic.rpartition("/")[2]
    elsewhere = [other for other in others if other.rpartition("/")[2] == last and other != topic]
    if len(elsewhere) == 1:
        return elsewhere[0]
    close = difflib.get_close_matches(topic, [other for other in others if other != topic], 1, _NEAR)
    return close[0] if close else None


def _links(system: System) -> Iterator[Finding]:
    missing = missing_edges(system)
    explained = _mismatched(system)
    left = [edge for edge in missing if edge.topic not in explained]
    if left:
        yield Finding(
            "missing-link",
            ERROR,
            "The following nodes should be connected but aren't:",
            "restart the subscriber; if that does not help, look for a firewall, an address that only one side knows "
            "(see above), or different definitions of the type: compare its `pyros1 msg md5`",
            tuple(_link_text(system, edge) for edge in left),
        )
    unexpected = _unexpected(system)
    if unexpected:
        yield Finding(
            "unexpected-link",
            WARNING,
            "The following nodes are connected, but the master does not know about it:",
            "they belong to another master, or the master was restarted: restart the nodes",
            tuple(f"{edge.publisher}->{edge.subscriber} ({edge.topic})" for edge in unexpected),
        )


def _mismatched(system: System) -> set[str]:
    """Return topics whose ends do not match, which explains their missing connections."""
    found = set()
    for topic in {end.topic for end in system.publications}:
        offers = [o for _, o in (*_known(system.publications, topic), *_known(system.subscriptions, topic))]
        if any(len({getattr(offer, part) for offer in offers} - {"*"}) > 1 for part in ("type", "md5sum")):
            found.add(topic)
    return found


def _link_text(system: System, edge: Edge) -> str:
    failure = system.publications.get(End(edge.topic, edge.publisher), Offer()).failure
    why = f": {failure.text}" if failure is not None else ""
    return f"{edge.publisher}->{edge.subscriber} ({edge.topic}){why}"


def _alive(system: System) -> dict[str, list[Connection]]:
    return {name: list(node.connections) for name, node in system.nodes.items() if node.failure is None}


def missing_edges(system: System) -> list[Edge]:
    """Return expected connections between nodes that answer, unless both ends report them."""
    told = _told(system)
    return [edge for edge in expected_edges(system.state) if is_lacking(edge, told)]


def _told(system: System) -> dict[str, set[Edge]]:
    uris = {name: node.uri for name, node in system.nodes.items()}
    return actual_edges(_alive(system), uris)


def _unexpected(system: System) -> list[Edge]:
    known = {*system.state.publishers, *system.state.subscribers}
    nodes = system.nodes
    return sorted(
        edge
        for edge in set().union(*_told(system).values()) - set(expected_edges(system.state))
        if edge.topic in known and edge.publisher in nodes and edge.subscriber in nodes
    )
