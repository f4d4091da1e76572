"""Checks of a running system: unpublished topics, mismatched types, missing connections.

This module has no side effects.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping

from pyros1.doctor.edges import Edge, actual_edges, expected_edges, is_missing_edge
from pyros1.doctor.facts import ReportedType, System, TopicParticipant
from pyros1.doctor.finding import ERROR, WARNING, Finding
from pyros1.graph import Connection

_IGNORED_TOPICS = frozenset({"/clock", "/rosout", "/statistics", "/tf_static"})
"""Topics that may lack publishers or subscribers without this being a problem."""
_MIN_SIMILARITY = 0.75
"""Minimum similarity of two names, from 0 to 1, for one to be suggested in place of the other."""


def check_topics(system: System) -> list[Finding]:
    """Return the problems with the topics of a system."""
    checks = (_check_clock, _check_types, _check_lengths, _check_unpublished, _check_connections, _check_low_latency)
    return [finding for check in checks for finding in check(system)]


def _check_clock(system: System) -> Iterator[Finding]:
    publishers = system.state.publishers.get("/clock", [])
    responding_publishers = [name for name in publishers if name in system.nodes and system.nodes[name].failure is None]
    if system.use_sim_time and not responding_publishers:
        yield Finding(
            "no-clock",
            ERROR,
            "/use_sim_time is true, but no node publishes /clock: time stays at 0 in all nodes",
            "start the simulator (or `rosbag play --clock`), or: pyros1 param set /use_sim_time false, and restart the "
            "nodes",
        )
    elif responding_publishers and not system.use_sim_time:
        yield Finding(
            "unused-clock",
            WARNING,
            "/clock is published, but /use_sim_time is not true: nodes run on the wall clock",
            "pyros1 param set /use_sim_time true, before the nodes start",
            tuple(responding_publishers),
        )


def _check_types(system: System) -> Iterator[Finding]:
    for topic in sorted({participant.topic for participant in (*system.publications, *system.subscriptions)}):
        reported_types = {
            f"publisher {participant.node}": reported
            for participant, reported in _responses(system.publications, topic)
        }
        reported_types |= {
            f"subscriber {participant.node}": reported
            for participant, reported in _responses(system.subscriptions, topic)
        }
        types = {reported.type for reported in reported_types.values()} - {"*"}
        md5sums = {reported.md5sum for reported in reported_types.values()} - {"*"}
        if len(types) > 1:
            yield Finding(
                "type-mismatch",
                ERROR,
                f"the nodes of topic {topic} do not agree on its type: {', '.join(map(str, sorted(types)))}",
                "nodes with different types cannot connect: correct the type, or remap some of them to another topic",
                tuple(f"{participant_name}: {reported.type}" for participant_name, reported in reported_types.items()),
            )
        elif len(md5sums) > 1:
            name = next(iter(types), "*")
            yield Finding(
                "md5-mismatch",
                ERROR,
                f"the nodes of topic {topic} have different definitions of {name}",
                f"compare `pyros1 msg md5 {name}` on their machines, rebuild the older package, and restart its nodes",
                tuple(
                    f"{participant_name}: {reported.md5sum}" for participant_name, reported in reported_types.items()
                ),
            )


def _check_lengths(system: System) -> Iterator[Finding]:
    """Check for publishers whose messages have the wrong length."""
    wrong_publications = [
        (participant, reported) for participant, reported in sorted(system.publications.items()) if reported.extra_bytes
    ]
    if wrong_publications:
        yield Finding(
            "odd-ends",
            WARNING,
            "The messages of the following publishers are longer or shorter than their type requires; subscribers "
            "accept them:",
            "compare the type's definition on the publisher's machine with `pyros1 msg show` here; boards with an old "
            "rosserial library append a checksum byte: update that library",
            tuple(
                f"{participant.node}: {participant.topic} ({reported.type}): {_length_text(reported.extra_bytes)}"
                for participant, reported in wrong_publications
            ),
        )


def _length_text(extra_bytes: int) -> str:
    count_text = f"{abs(extra_bytes)} byte{'s' * (abs(extra_bytes) != 1)}"
    return f"{count_text} too many" if extra_bytes > 0 else f"{count_text} missing"


def _responses(
    reported_types: Mapping[TopicParticipant, ReportedType], topic: str
) -> list[tuple[TopicParticipant, ReportedType]]:
    return [
        (participant, reported)
        for participant, reported in sorted(reported_types.items())
        if participant.topic == topic and reported.failure is None
    ]


def _check_low_latency(system: System) -> Iterator[Finding]:
    """Check for subscriptions with ``low_latency=True`` that have too little processor time for it."""
    paused = sorted(
        {
            f"{node}: {connection.topic}"
            for node, facts in system.nodes.items()
            for connection in facts.connections
            if connection.polling_paused
        }
    )
    if paused:
        yield Finding(
            "low-latency",
            WARNING,
            "There is too little processor time for the low_latency=True of the following nodes: they sleep until a "
            "message arrives. The machine is busy, or the container's limit does not leave a whole processor",
            "move some programs to another machine, reserve a processor for the node (isolcpus and taskset), or raise "
            "the container's limit (`docker run --cpus`) to one processor more than its programs need",
            tuple(paused),
        )


def _check_unpublished(system: System) -> Iterator[Finding]:
    """Check for topics that are subscribed to but not published, and for similar names."""
    state = system.state
    similar_notes: list[str] = []
    unpublished_notes: list[str] = []
    for topic, nodes in sorted(state.subscribers.items()):
        if state.publishers.get(topic) or topic in _IGNORED_TOPICS:
            continue
        similar_topic = similar_topic_name(topic, [name for name in state.publishers if name not in _IGNORED_TOPICS])
        for node in nodes:
            if similar_topic is None:
                unpublished_notes.append(f"{node}: {topic}")
            else:
                similar_notes.append(
                    f"{node} subscribes to {topic}; "
                    f"{', '.join(map(str, state.publishers[similar_topic]))} publishes {similar_topic}"
                )
    if similar_notes:
        yield Finding(
            "near-miss",
            WARNING,
            "The following topics have no publisher, but topics with similar names do:",
            "correct the name, or remap: FROM:=TO on the command line, <remap from= to=> in the launch file",
            tuple(similar_notes),
        )
    if unpublished_notes:
        yield Finding(
            "no-publisher",
            WARNING,
            "The following node subscriptions are unconnected: no node publishes their topics",
            "start the nodes that publish them; if they are running, compare the names: pyros1 topic list -v",
            tuple(unpublished_notes),
        )


def similar_topic_name(topic: str, others: list[str]) -> str | None:
    """Return a topic with a similar name or with the same name in another namespace; None if no topic fits."""
    base_name = topic.rpartition("/")[2]
    same_name = [other for other in others if other.rpartition("/")[2] == base_name and other != topic]
    if len(same_name) == 1:
        return same_name[0]
    matches = difflib.get_close_matches(topic, [other for other in others if other != topic], 1, _MIN_SIMILARITY)
    return matches[0] if matches else None


def _check_connections(system: System) -> Iterator[Finding]:
    missing_connections = missing_edges(system)
    mismatched_topics = _mismatched_topics(system)
    unexplained = [edge for edge in missing_connections if edge.topic not in mismatched_topics]
    if unexplained:
        yield Finding(
            "missing-link",
            ERROR,
            "The following nodes should be connected but aren't:",
            "restart the subscriber; if that does not help, look for a firewall, an address that only one side knows "
            "(see above), or different definitions of the type (compare `pyros1 msg md5 TYPE` on both machines)",
            tuple(_edge_text(system, edge) for edge in unexplained),
        )
    unexpected = _unexpected_edges(system)
    if unexpected:
        yield Finding(
            "unexpected-link",
            WARNING,
            "The following nodes are connected, but the master does not know about the connections:",
            "they belong to another master, or the master was restarted: restart the nodes",
            tuple(f"{edge.publisher}->{edge.subscriber} ({edge.topic})" for edge in unexpected),
        )


def _mismatched_topics(system: System) -> set[str]:
    """Return the topics whose participants report different types, which explains why connections are missing."""
    mismatched = set()
    for topic in {participant.topic for participant in system.publications}:
        reported_types = [
            response
            for _, response in (*_responses(system.publications, topic), *_responses(system.subscriptions, topic))
        ]
        if any(
            len({getattr(reported, attribute) for reported in reported_types} - {"*"}) > 1
            for attribute in ("type", "md5sum")
        ):
            mismatched.add(topic)
    return mismatched


def _edge_text(system: System, edge: Edge) -> str:
    failure = system.publications.get(TopicParticipant(edge.topic, edge.publisher), ReportedType()).failure
    reason = f": {failure.text}" if failure is not None else ""
    return f"{edge.publisher}->{edge.subscriber} ({edge.topic}){reason}"


def _connections_of_responding_nodes(system: System) -> dict[str, list[Connection]]:
    return {name: list(node.connections) for name, node in system.nodes.items() if node.failure is None}


def missing_edges(system: System) -> list[Edge]:
    """Return the expected connections between responding nodes that at most one of the two ends reports."""
    reported = _reported_edges(system)
    return [edge for edge in expected_edges(system.state) if is_missing_edge(edge, reported)]


def _reported_edges(system: System) -> dict[str, set[Edge]]:
    uris = {name: node.uri for name, node in system.nodes.items()}
    return actual_edges(_connections_of_responding_nodes(system), uris)


def _unexpected_edges(system: System) -> list[Edge]:
    known_topics = {*system.state.publishers, *system.state.subscribers}
    nodes = system.nodes
    return sorted(
        edge
        for edge in set().union(*_reported_edges(system).values()) - set(expected_edges(system.state))
        if edge.topic in known_topics and edge.publisher in nodes and edge.subscriber in nodes
    )
