"""Checks of bridges between masters: connections, sites, topics that do not arrive. This module has no side effects."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from pyros1 import __version__
from pyros1.doctor.facts import System
from pyros1.doctor.finding import ERROR, WARNING, Finding
from pyros1.ground.terminal_text import one_line

ROS2 = "ros2"
"""The dialect in the status of a bridge to ROS 2."""
LOST, PRESENT = "lost", "present"
"""States of other sites in a status."""
NO_RULE = "no rule takes it"
"""State of another site's topic that no rule requests."""
OTHER_VERSION = "a packet of another version of pyros1"
"""Reason in a status for ignoring packets: the other site uses another protocol version."""
INTENDED = ("subscribed", "no subscribers here", "site lost", "denied by a rule", NO_RULE)
"""States of other sites' topics that do not indicate a problem with the topic."""
DROPS: Mapping[str, str] = {
    "too old": "the network is too slow or too often interrupted: raise the topic's age if older messages are of use",
    "too large": "raise the topic's size, at both sites",
    "with a different md5sum": "its publishers do not agree on the type's definition: rebuild the older one",
    "lost": "the network loses messages: lower the topic's rate or size",
    "from too many publishers": "too many nodes have published this topic: restart the bridge",
    "queue full, since the network is too slow": "limit rates (/topic@5) and sizes of large topics, or send less",
}
"""Reason why messages are dropped -> what to do about it. Other reasons are normal."""
_MIN_DROPS = 10
_MIN_SHARE = 0.05
"""Only topics that drop at least `_MIN_DROPS` messages, and at least this share of all messages, are reported."""
_Statuses = Mapping[str, Mapping[str, Any]]


def check_bridges(system: System) -> list[Finding]:
    """Return the problems with the bridges of a system."""
    statuses: dict[str, Mapping[str, Any]] = {}
    findings = []
    for name, status in sorted(system.bridges.items()):
        try:
            _find_all({name: status}, system)
            statuses[name] = status
        except (KeyError, TypeError, AttributeError, ValueError):
            findings.append(_unreadable_finding(name))
    return [*findings, *_find_all(statuses, system)]


def _find_all(statuses: _Statuses, system: System) -> list[Finding]:
    checks: tuple[Callable[[_Statuses, System], Iterator[Finding]], ...] = (
        _check_versions,
        _check_links,
        _check_sites,
        _check_refused,
        _check_wanted,
        _check_problems,
        _check_drops,
    )
    return [finding for check in checks for finding in check(statuses, system)]


def _unreadable_finding(name: str) -> Finding:
    return Finding(
        "bridge-version",
        WARNING,
        f"the status of the bridge {name} cannot be read: it runs another version of pyros1",
        "install the same version there, and restart the bridge",
    )


def _check_versions(statuses: _Statuses, system: System) -> Iterator[Finding]:
    others = tuple(
        f"{name}: {one_line(version)}"
        for name, status in statuses.items()
        if (version := str(status.get("version", __version__))) != __version__
    )
    if others:
        yield Finding(
            "bridge-version",
            WARNING,
            f"The following bridges run another version of pyros1 than this one ({__version__}):",
            "restart them with this version, or install theirs here",
            others,
        )
    strangers = tuple(
        f"{name}: {one_line(reason.partition(':')[0])}"
        for name, status in statuses.items()
        for reason in status["ignored"]
        if reason.endswith(OTHER_VERSION)
    )
    if strangers:
        yield Finding(
            "bridge-protocol",
            ERROR,
            "The following sites run another version of pyros1, so nothing is exchanged with them:",
            "install the same version at all sites: pip install -U 'pyros1[bridge]'",
            strangers,
        )


def _check_links(statuses: _Statuses, system: System) -> Iterator[Finding]:
    unreached = {name: one_line(status["link"]) for name, status in statuses.items() if status["link"]}
    alone = [name for name, status in statuses.items() if not status["link"] and not status["sites"]]
    to_ros2 = {name for name, status in statuses.items() if status.get("dialect") == ROS2}
    through_rclpy = {name for name in to_ros2 if statuses[name].get("via") == "rclpy"}
    if items := tuple(f"{name}: {problem}" for name, problem in unreached.items() if name in through_rclpy):
        yield Finding(
            "bridge-rclpy",
            ERROR,
            "The following bridges have problems with rclpy:",
            "look at what they log, and start them again",
            items,
        )
    if items := tuple(name for name in alone if name in through_rclpy):
        yield Finding(
            "bridge-ros2-alone",
            WARNING,
            "The following bridges have found no ROS 2 nodes:",
            "check that nodes run there with the bridge's RMW_IMPLEMENTATION and ROS_DOMAIN_ID (pyros1 bridge status "
            "shows it), and that ros2 node list finds them on the bridge's machine",
            items,
        )
    through_zenoh = to_ros2 - through_rclpy
    if items := tuple(f"{name}: {problem}" for name, problem in unreached.items() if name in through_zenoh):
        yield Finding(
            "bridge-ros2-link",
            ERROR,
            "The following bridges have no connection to ROS 2:",
            "start its router there (ros2 run rmw_zenoh_cpp rmw_zenohd), or let the bridge be the router "
            "(pyros1 bridge ros2 --listen tcp/localhost:7447)",
            items,
        )
    if items := tuple(name for name in alone if name in through_zenoh):
        yield Finding(
            "bridge-ros2-alone",
            WARNING,
            "The following bridges have found no ROS 2 nodes:",
            "check that nodes run there with RMW_IMPLEMENTATION=rmw_zenoh_cpp, with the same router, and with the "
            "bridge's ROS_DOMAIN_ID (pyros1 bridge status shows it)",
            items,
        )
    items = tuple(f"{name}: {problem}" for name, problem in unreached.items() if name not in to_ros2)
    if items:
        yield Finding(
            "bridge-link",
            ERROR,
            "The following bridges have no connection to other sites:",
            "check that the other site listens (pyros1 bridge status there), its host name and port, the keys of both, "
            "and that no firewall blocks the port",
            items,
        )
    if items := tuple(name for name in alone if name not in to_ros2):
        yield Finding(
            "bridge-alone",
            WARNING,
            "The following bridges have not found another site yet:",
            "start the bridges of the other sites; if they run, compare --sites, --to and --listen (pyros1 bridge "
            "--check)",
            items,
        )


def _check_sites(statuses: _Statuses, system: System) -> Iterator[Finding]:
    items = tuple(
        f"{name}: {one_line(site['name'])}" + ("" if site["state"] == LOST else " has been heard, but does not answer")
        for name, status in statuses.items()
        for site in status["sites"]
        if site["state"] != PRESENT
    )
    if items:
        yield Finding(
            "bridge-site",
            ERROR,
            "The following sites do not respond:",
            "check the network to them, and there: pyros1 bridge status",
            items,
        )
    shared = tuple(
        f"{name}: {one_line(site['name'])}"
        for name, status in statuses.items()
        for site in status["sites"]
        if site.get("shared")
    )
    if shared:
        yield Finding(
            "bridge-name",
            ERROR,
            "Two bridges use the same name, so their messages arrive alternately or not at all:",
            "stop one of them, or give it another --site and keys with that name",
            shared,
        )


def _check_refused(statuses: _Statuses, system: System) -> Iterator[Finding]:
    items = tuple(
        f"{name}: {one_line(entry['topic'])}: {one_line(entry['state'])}"
        for name, status in statuses.items()
        for entry in status["received"]
        if entry["state"] not in INTENDED and "dialect" not in status  # zenoh-plugin-ros1 has other states
    )
    if items:
        yield Finding(
            "bridge-refused",
            WARNING,
            "The following topics of other sites are not published here:",
            "give them another name here (`here:` in the bridge's file, see pyros1 guide howto sites), or deny them "
            "(--take '!SITE:/topic')",
            items,
        )


def _check_wanted(statuses: _Statuses, system: System) -> Iterator[Finding]:
    """Check for subscribers that wait for another site's topic that no rule takes."""
    items = []
    topics = []
    for entry in (entry for status in statuses.values() for entry in status["received"]):
        usual = entry.get("usual", "")
        nodes = system.state.subscribers.get(usual, [])
        if entry["state"] == NO_RULE and nodes and not system.state.publishers.get(usual):
            items += [f"{node}: {usual}" for node in nodes]
            topics.append(one_line(entry["topic"]))
    if items:
        yield Finding(
            "bridge-not-taken",
            WARNING,
            "The following nodes subscribe to topics that another site offers, but no rule takes:",
            f"restart the bridge with --take {' '.join(_quoted(topic) for topic in topics[:5])}",
            tuple(items),
        )


def _quoted(topic: str) -> str:
    return "'" + topic.replace("'", "") + "'"


def _check_problems(statuses: _Statuses, system: System) -> Iterator[Finding]:
    items = tuple(
        f"{name}: {one_line(topic)}: {one_line(problem)}"
        for name, status in statuses.items()
        for topic, problem in status["problems"].items()
    )
    if items:
        yield Finding(
            "bridge-topic",
            WARNING,
            "The following topics cannot be sent to other sites, or not all of their messages:",
            "check that their publishers respond (pyros1 node list --check), agree on the type, and can be converted",
            items,
        )


def _check_drops(statuses: _Statuses, system: System) -> Iterator[Finding]:
    found: dict[str, list[str]] = {}
    for name, status in statuses.items():
        for entry in (*status["sent"], *status["received"]):
            for reason, number in entry["dropped"].items():
                if reason in DROPS and number >= _MIN_DROPS and number >= _MIN_SHARE * (number + entry["messages"]):
                    total = number + entry["messages"]
                    found.setdefault(reason, []).append(f"{name}: {one_line(entry['topic'])}: {number} of {total}")
    for reason, items in found.items():
        yield Finding(
            "bridge-drops",
            WARNING,
            f"Messages of the following topics were dropped by a bridge, {reason}:",
            DROPS[reason],
            tuple(items),
        )
