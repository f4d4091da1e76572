"""Collects facts about a running system. All requests are sent concurrently."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from functools import partial
from time import sleep

from pyros1.doctor.bridge_status import fetch_statuses
from pyros1.doctor.concurrent import run_concurrently
from pyros1.doctor.facts import TIMEOUT, Failure, NodeFacts, ReportedType, System, TopicParticipant
from pyros1.doctor.probe import NODE_TIMEOUT, classify_error, query_node, query_publisher
from pyros1.doctor.topic_checks import missing_edges
from pyros1.graph import Graph, NodeApi, probe_service
from pyros1.ground.errors import Error
from pyros1.net.hosts import parse_uri
from pyros1.net.master_client import MasterClient

ROUND_TIMEOUT = NODE_TIMEOUT + 0.5
"""Timeout for a round of requests in seconds."""
MESSAGE_TIMEOUT = 0.5
"""Time in seconds to wait for a publisher's message, whose length is checked."""
CONNECT_TIMEOUT = 1.0
"""Time in seconds that new nodes are given to connect before they are queried again."""


def collect_system(master: MasterClient, only: Collection[str] | None = None) -> System:
    """Query the master, then all nodes and services, then publishers and subscribers about their types.

    Args:
        master: the system's master.
        only: the names of the nodes to query, together with the services that they provide; None for all nodes.

    Returns:
        The facts. This takes up to about ten seconds.

    Raises:
        MasterUnreachableError: the master does not respond.
    """
    state = Graph(master).state()
    use_sim_time = _get_param(master, "/use_sim_time") is True
    node_names = set(state.nodes()) if only is None else set(only)
    selected_services = [name for name, owners in state.services.items() if not node_names.isdisjoint(owners)]
    uris = _lookup_uris(master, "lookupNode", sorted(node_names.intersection(state.nodes())))
    service_uris = _lookup_uris(master, "lookupService", sorted(selected_services))
    jobs: dict[tuple[str, str], Callable[[], NodeFacts | dict[str, str]]] = {
        ("node", name): partial(query_node, master.caller_id, uri) for name, uri in uris.items()
    }
    jobs |= {
        ("service", name): partial(probe_service, name, uri, master.caller_id, NODE_TIMEOUT)
        for name, uri in service_uris.items()
    }
    results = run_concurrently(jobs, ROUND_TIMEOUT)
    nodes = {name: _to_node_facts(uris[name], results["node", name]) for name in uris}
    services = {name: (uri, _to_failure(results["service", name])) for name, uri in service_uris.items()}
    system = System(master.uri, state, nodes, services, use_sim_time=use_sim_time)
    if missing_edges(system):
        sleep(CONNECT_TIMEOUT)  # new nodes may not be connected yet
        unconnected = {name for edge in missing_edges(system) for name in (edge.publisher, edge.subscriber)}
        new_results = run_concurrently(
            {name: partial(query_node, master.caller_id, uris[name]) for name in unconnected}, ROUND_TIMEOUT
        )
        system.nodes = {**nodes, **{name: _to_node_facts(uris[name], result) for name, result in new_results.items()}}
    _query_types(master, system)
    if only is None:
        statuses = fetch_statuses(Graph(master), state)
        system.bridges = {name: found for name, found in statuses.items() if not isinstance(found, Exception)}
    return system


def _get_param(master: MasterClient, name: str) -> object:
    try:
        return master.get_param(name)
    except Error:
        return None


def _lookup_uris(master: MasterClient, method: str, names: list[str]) -> dict[str, str]:
    """Return the URIs of nodes or services by name, looked up in one call, without those that have exited."""
    if not names:
        return {}
    try:
        values = master.multicall([(method, [name]) for name in names])
    except Error:
        return {}
    return {name: value for name, value in zip(names, values, strict=True) if isinstance(value, str)}


def _to_node_facts(uri: str, result: object) -> NodeFacts:
    if isinstance(result, NodeFacts):
        return result
    try:
        host = parse_uri(uri)[0]
    except Error:
        host = uri
    return NodeFacts(uri, host, (), Failure(TIMEOUT, str(result)))


def _to_failure(result: object) -> Failure | None:
    return classify_error(result) if isinstance(result, Exception) else None


def _query_types(master: MasterClient, system: System) -> None:
    """Add the types of publishers whose peers may use other types, and of unconnected subscribers, to the facts."""
    state, nodes = system.state, system.nodes
    shared_topics = [
        topic
        for topic, publishers in state.publishers.items()
        if len(publishers) + len(state.subscribers.get(topic, ())) > 1
    ]
    participants = [
        TopicParticipant(topic, node)
        for topic in shared_topics
        for node in state.publishers[topic]
        if node in nodes and nodes[node].failure is None
    ]
    results = run_concurrently(
        {
            participant: partial(
                query_publisher, master.caller_id, nodes[participant.node].uri, participant.topic, MESSAGE_TIMEOUT
            )
            for participant in participants
        },
        ROUND_TIMEOUT,
    )
    system.publications = _reported_types(results)
    unconnected_subscribers = dict.fromkeys(edge.subscriber for edge in missing_edges(system))
    subscriptions = run_concurrently(
        {name: partial(_query_subscriptions, master.caller_id, nodes[name].uri) for name in unconnected_subscribers},
        ROUND_TIMEOUT,
    )
    system.subscriptions = {
        TopicParticipant(edge.topic, edge.subscriber): _subscription_type(subscriptions[edge.subscriber], edge.topic)
        for edge in missing_edges(system)
    }


def _reported_types(
    results: Mapping[TopicParticipant, ReportedType | Exception],
) -> dict[TopicParticipant, ReportedType]:
    return {
        participant: ReportedType(failure=classify_error(result)) if isinstance(result, Exception) else result
        for participant, result in results.items()
    }


def _query_subscriptions(caller_id: str, uri: str) -> dict[str, str]:
    api = NodeApi(caller_id, uri, NODE_TIMEOUT)
    try:
        return api.subscriptions()
    finally:
        api.close()


def _subscription_type(result: dict[str, str] | Exception, topic: str) -> ReportedType:
    if isinstance(result, Exception):
        return ReportedType(failure=classify_error(result))
    return ReportedType(result.get(topic, "*"))
