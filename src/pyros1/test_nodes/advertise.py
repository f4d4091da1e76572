"""advertisetest and subscribetest check that topics and services are registered, or not registered."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

from pyros1.graph import Graph, probe_service
from pyros1.ground.errors import Error
from pyros1.test_nodes.common import POLL_INTERVAL, SetupError, Test, list_param, pause, require, wait_for_clock

if TYPE_CHECKING:
    from pyros1.node import Node

_DEFAULTS = {"timeout": 10, "type": None, "negative": False}
_ListNames = Callable[[], Iterable[str]]
_GetType = Callable[[str], "str | None"]


def advertise_tests(node: Node) -> dict[str, Test]:
    """Return the test cases of advertisetest, by name.

    Args:
        node: the node; its parameters ~topics and ~services are
            ``[{name: NAME, timeout: SECONDS, type: TYPE, negative: BOOL}, ...]`` with full names.

    Raises:
        SetupError: the parameters contain nothing to test.
    """
    graph = Graph(node.master)
    topics, services = list_param(node, "topics", _DEFAULTS), list_param(node, "services", _DEFAULTS)
    if not topics and not services:
        raise SetupError(f"{node.resolve('~topics')} and {node.resolve('~services')} contain nothing to test")

    def service_type(name: str) -> str | None:
        uri = graph.service_uri(name)
        try:
            return probe_service(name, uri, node.name).get("type") if uri else None
        except Error:
            return None

    return {
        "test_advertise_services": lambda: _check_names(node, services, lambda: graph.state().services, service_type),
        "test_advertise_topics": lambda: _check_names(node, topics, graph.published_types, graph.topic_types().get),
    }


def subscribe_tests(node: Node) -> dict[str, Test]:
    """Return the test cases of subscribetest, by name.

    Args:
        node: the node; its parameter ~topics is ``[{name: NAME, timeout: SECONDS, type: TYPE, negative: BOOL}, ...]``.

    Raises:
        SetupError: the parameters contain nothing to test.
    """
    graph = Graph(node.master)
    topics = list_param(node, "topics", _DEFAULTS)
    if not topics:
        raise SetupError(f"{node.resolve('~topics')} contains no topic to test")
    return {
        "test_subscribe_topics": lambda: _check_names(
            node, topics, lambda: graph.state().subscribers, lambda name: graph.topic_types().get(name)
        )
    }


def _check_names(node: Node, entries: list[dict[str, Any]], list_names: _ListNames, get_type: _GetType) -> None:
    """Check which names are registered, repeatedly, until all names have appeared or the longest timeout has passed.

    Args:
        entries: the entries of the parameter. Their names should appear, or should not if ``negative`` is true.
        list_names: returns the currently registered names.
        get_type: returns the type of a name; None if it is unknown.
    """
    wait_for_clock(node)
    missing_entries = {entry["name"]: entry for entry in entries}
    timeout = max((float(entry["timeout"]) for entry in missing_entries.values()), default=0.0)
    start = time.monotonic()
    while missing_entries and (elapsed := time.monotonic() - start) <= timeout:
        for name in [name for name in list_names() if name in missing_entries]:
            _check_entry(missing_entries.pop(name), elapsed, get_type)
        if missing_entries:
            pause(node, POLL_INTERVAL)
    for name, entry in missing_entries.items():
        require(entry["negative"], f"{name} did not appear within {entry['timeout']} s")


def _check_entry(entry: dict[str, Any], elapsed: float, get_type: _GetType) -> None:
    name, expected_type = entry["name"], entry["type"]
    require(not entry["negative"], f"{name} exists, but should not")
    require(elapsed < float(entry["timeout"]), f"{name} appeared only after {elapsed:.1f} s")
    if expected_type is not None:
        actual_type = get_type(name)
        require(actual_type == expected_type, f"{name} should be of type {expected_type}, but is of type {actual_type}")
