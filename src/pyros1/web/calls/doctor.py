"""Calls that return what ``pyros1 wtf`` finds about one topic or node. Only the nodes involved are queried."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import replace
from typing import Any

from pyros1.doctor.connectivity_checks import check_connectivity
from pyros1.doctor.finding import Finding
from pyros1.doctor.local_facts import collect_machine
from pyros1.doctor.system import collect_system
from pyros1.doctor.topic_checks import check_topics
from pyros1.web.robot import Robot
from pyros1.web.server.wire import RequestError
from pyros1.web.views.view import string_arg

_MAX_ITEMS = 100
_MAX_NODES = 200
"""Maximum number of nodes queried."""
_GLOBAL_KINDS = frozenset({"no-clock", "unused-clock"})
"""Kinds of findings that do not mention a topic, but may be the reason why no messages arrive."""
_NAME_PATTERN = re.compile(r"/[A-Za-z0-9_/]*[A-Za-z0-9_]")


def topic(robot: Robot, args: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the problems with a topic, its publishers and its subscribers, as from `Finding.as_json`. Args: topic."""
    name = string_arg(args, "topic")
    robot.check_visible(name)
    state = robot.graph.state()
    return _find_problems(robot, name, [*state.publishers.get(name, ()), *state.subscribers.get(name, ())])


def node(robot: Robot, args: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the problems with a node, its topics and its services, as from `Finding.as_json`. Args: node.

    Raises:
        RequestError: the node does not exist.
    """
    name = string_arg(args, "node")
    state = robot.graph.state()
    if name not in state.nodes():
        raise RequestError(f"there is no node {name}")
    node_state = state.of_node(name)
    topics = robot.access.visible_names([*node_state.publications, *node_state.subscriptions])
    peers = [peer for topic in topics for peer in (*state.publishers.get(topic, ()), *state.subscribers.get(topic, ()))]
    return _find_problems(robot, name, [name, *peers])


def _find_problems(robot: Robot, name: str, nodes: Iterable[str]) -> list[dict[str, Any]]:
    system = collect_system(robot.master, list(dict.fromkeys(nodes))[:_MAX_NODES])
    machine = collect_machine({**os.environ, "ROS_MASTER_URI": robot.master_uri})
    all_names = {*system.state.publishers, *system.state.subscribers, *system.state.services}
    hidden = {name_in_use for name_in_use in all_names if not robot.access.may_see(name_in_use)}
    findings = [*check_connectivity(system, machine), *findings_about(check_topics(system), name)]
    return [finding.as_json() for finding in without_hidden(findings, hidden)]


def findings_about(findings: Iterable[Finding], name: str) -> list[Finding]:
    """Return the findings about a topic or node. If only some of a finding's items mention it, only these are kept."""
    selected = []
    for finding in findings:
        items = finding.items
        if name not in _names_in(finding.text):
            items = tuple(item for item in items if name in _names_in(item))
            if not items and finding.kind not in _GLOBAL_KINDS:
                continue
        selected.append(replace(finding, items=items[:_MAX_ITEMS]))
    return selected


def without_hidden(findings: Iterable[Finding], hidden: Collection[str]) -> list[Finding]:
    """Return the findings without those that mention hidden names, and without items that mention hidden names."""
    visible = []
    for finding in findings:
        items = tuple(item for item in finding.items if _names_in(item).isdisjoint(hidden))
        if _names_in(finding.text).isdisjoint(hidden) and (items or not finding.items):
            visible.append(replace(finding, items=items))
    return visible


def _names_in(line: str) -> set[str]:
    return set(_NAME_PATTERN.findall(line))


CALLS: dict[str, Callable[[Robot, Mapping[str, Any]], Any]] = {"topic": topic, "node": node}
CHANGES: frozenset[str] = frozenset()
