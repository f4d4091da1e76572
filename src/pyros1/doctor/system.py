"""Collects facts about a running system. All requests are sent concurrently."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from functools import partial
from time import sleep

from pyros1.doctor.concurrent import run_concurrently
from pyros1.doctor.facts import TIMEOUT, Failure, NodeFacts, ReportedType, System, TopicEnd
from pyros1.doctor.probe import NODE_TIMEOUT, ask_node, ask_publisher, failure_of
from pyros1.doctor.topic_checks import missing_edges
from pyros1.graph import Graph, NodeApi, probe_service
from pyros1.ground.errors import Error
from pyros1.net.hosts import parse_uri
from pyros1.net.master_client import MasterClient

ROUND_TIMEOUT = NODE_TIMEOUT + 0.5
"""Timeout in seconds for one round of requests."""
MESSAGE_TIMEOUT = 0.5
"""Seconds to wait for a publisher's message, to check its length."""
CONNECT_TIME = 1.0
"""Seconds that new nodes have to connect."""


def collect_system(master: MasterClient, only: Collection[str] | None = None) -> System:
    """Ask the master, then all nodes and services, then the ends of topics about their types.

    Args:
        master: the system's master.
        only: names of the nodes to ask, with the services that they provide; None for all.

    Returns:
        The facts, within about ten seconds.

    Raises:
        MasterUnreachableError: the master does not answer.
    """
    state = Graph(master).state()
    simulated = _parameter(master, "/use_sim_time") is True
    node_names = set(state.nodes()) if only is None else set(only)
    services_of = [name for name, owners in state.services.items() if not node_names.isdisjoint(owners)]
    uris = _uris(master, "lookupNode", sorted(node_names.intersection(state.nodes())))
    service_uris = _uris(master, "lookupService", sorted(services_of))
    jobs: dict[tuple[str, str], Callable[[], NodeFacts | dict[str, str]]] = {
        ("node", name): partial(ask_node, master.caller_id, uri) for name, uri in uris.items()
    }
    jobs |= {
        ("service", name): partial(probe_service, name, uri, master.caller_id, NODE_TIMEOUT)
        for name, uri in service_uris.items()
    }
    answers = run_concurrently(jobs, ROUND_TIMEOUT)
    nodes = {name: _node(uris[name], answers["node", name]) for name in uris}
    services = {name: (uri, _failure(answers["service", name])) for name, uri in service_uris.items()}
    system = System(master.uri, state, nodes, services, use_sim_time=simulated)
    if missing_edges(system):
        sleep(CONNECT_TIME)  # new nodes may not be connected yet
        unconnected = {name for edge in missing_edges(system) for name in (edge.publisher, edge.subscriber)}
        answers_again = run_concurrently(
            {name: partial(ask_node, master.caller_id, uris[name]) for name in unconnected}, ROUND_TIMEOUT
        )
        system.nodes = {**nodes, **{name: _node(uris[name], answer) for name, answer in answers_again.items()}}
    _ask_for_types(master, system)
    return system


def _parameter(master: MasterClient, name: str) -> object:
    try:
        return master.get_param(name)
    except Error:
        return None


def _uris(master: MasterClient, method: str, names: list[str]) -> dict[str, str]:
    """Return the URIs of nodes or services, except those that have exited. One call, if the master supports it."""
    if not names:
        return {}
    try:
        values = master.multicall([(method, [name]) for name in names])
    except Error:
        return {}
    return {name: value for name, value in zip(names, values, strict=True) if isinstance(value, str)}


def _node(uri: str, answer: object) -> NodeFacts:
    if isinstance(answer, NodeFacts):
        return answer
    try:
        host = parse_uri(uri)[0]
    except Error:
        host = uri
    return NodeFacts(uri, host, (), Failure(TIMEOUT, str(answer)))


def _failure(answer: object) -> Failure | None:
    return failure_of(answer) if isinstance(answer, Exception) else None


def _ask_for_types(master: MasterClient, system: System) -> None:
    """Ask publishers for their types where ends may differ, and subscribers that have no connection."""
    state, nodes = system.state, system.nodes
    shared = [
        topic
        for topic, publishers in state.publishers.items()
        if len(publishers) + len(state.subscribers.get(topic, ())) > 1
    ]
    ends = [
        TopicEnd(topic, node)
        for topic in shared
        for node in state.publishers[topic]
        if node in nodes and nodes[node].failure is None
    ]
    answers = run_concurrently(
        {
            end: partial(ask_publisher, master.caller_id, nodes[end.node].uri, end.topic, MESSAGE_TIMEOUT)
            for end in ends
        },
        ROUND_TIMEOUT,
    )
    system.publications = _reported_types(answers)
    unconnected_subscribers = dict.fromkeys(edge.subscriber for edge in missing_edges(system))
    subscriptions = run_concurrently(
        {name: partial(_subscriptions, master.caller_id, nodes[name].uri) for name in unconnected_subscribers},
        ROUND_TIMEOUT,
    )
    system.subscriptions = {
        TopicEnd(edge.topic, edge.subscriber): _subscription(subscriptions[edge.subscriber], edge.topic)
        for edge in missing_edges(system)
    }


def _reported_types(answers: Mapping[TopicEnd, ReportedType | Exception]) -> dict[TopicEnd, ReportedType]:
    return {
        end: ReportedType(failure=failure_of(answer)) if isinstance(answer, Exception) else answer
        for end, answer in answers.items()
    }


def _subscriptions(caller_id: str, uri: str) -> dict[str, str]:
    api = NodeApi(caller_id, uri, NODE_TIMEOUT)
    try:
        return api.subscriptions()
    finally:
        api.close()


def _subscription(answer: dict[str, str] | Exception, topic: str) -> ReportedType:
    if isinstance(answer, Exception):
        return ReportedType(failure=failure_of(answer))
    return ReportedType(answer.get(topic, "*"))
