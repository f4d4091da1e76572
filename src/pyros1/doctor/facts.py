"""The facts about a system that are collected first and then checked for problems."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from pyros1.graph import Connection, SystemState

UNRESOLVED, REFUSED, TIMEOUT, HANGS, OTHER = "unresolved", "refused", "timeout", "hangs", "other"
"""Reasons why something cannot be reached: the host name is unknown, the connection is refused, the connection times
out, connections are accepted but requests are not answered, or any other reason."""


class Failure(NamedTuple):
    """The reason why a request was not answered.

    Attributes:
        kind: UNRESOLVED, REFUSED, TIMEOUT, HANGS or OTHER.
        text: the error message.
    """

    kind: str
    text: str


class Disk(NamedTuple):
    """The free and total space in bytes on the disk that contains a folder, and whether the folder is writable."""

    folder: str
    free: int
    total: int
    writable: bool


class LocalProcess(NamedTuple):
    """A running ROS program on this machine. `master_uri` and `host` are from its environment variables; empty if
    unset.
    """

    pid: int
    name: str
    master_uri: str
    host: str


@dataclass
class Machine:
    """Facts about this machine and this shell.

    Attributes:
        environ: the environment variables.
        hostname: the machine's name.
        interfaces: the addresses of the network interfaces.
        resolved: the addresses of all relevant host names; None if a name cannot be resolved.
        missing_paths: entries of ROS_PACKAGE_PATH that are not folders.
        disks: the disks of the folders to which ROS writes.
        log_folder: the folder of log files.
        log_size: the size of that folder in bytes; a lower bound if counting took too long.
        masters: the URIs of the masters that are running on this machine.
        processes: the running ROS programs; empty if the operating system does not list them.
        python: the version of Python, such as ``(3, 11)``.
        launch_problems: problems in the launch files that the user has specified.
        package_problems: problems that make packages unusable.
        setting_problems: values of pyros1's environment variables that prevent nodes from starting.
    """

    environ: Mapping[str, str]
    hostname: str = "here"
    interfaces: Sequence[str] = ("127.0.0.1",)
    resolved: Mapping[str, Sequence[str] | None] = field(default_factory=dict)
    missing_paths: Sequence[str] = ()
    disks: Sequence[Disk] = ()
    log_folder: str = ""
    log_size: int = 0
    masters: Sequence[str] = ()
    processes: Sequence[LocalProcess] = ()
    python: tuple[int, int] = (3, 10)
    launch_problems: Sequence[str] = ()
    package_problems: Sequence[str] = ()
    setting_problems: Sequence[str] = ()


@dataclass
class NodeFacts:
    """Facts about a registered node.

    Attributes:
        uri: the URI of the node's API.
        host: the host in that URI.
        addresses: the addresses of the host as resolved on this machine; None if it cannot be resolved.
        failure: the reason why the node did not respond; None if it did.
        connections: the result of ``getBusInfo``.
        clock_offset: how far the clock on the node's machine is ahead of ours, in seconds; None if unknown.
    """

    uri: str
    host: str
    addresses: Sequence[str] | None = ()
    failure: Failure | None = None
    connections: Sequence[Connection] = ()
    clock_offset: float | None = None


class TopicParticipant(NamedTuple):
    """A publisher or subscriber of a topic."""

    topic: str
    node: str


class ReportedType(NamedTuple):
    """The type that a publisher or subscriber reports.

    Attributes:
        type, md5sum: the type and its checksum; ``*`` for any.
        failure: the reason why the node did not report the type; None if it did.
        definition: the full definition of the type if a publisher reported it.
        extra_bytes: the number of bytes after the end of the first message received while the publisher was queried;
            negative if bytes are missing.
        latched: whether the publisher latches its messages.
    """

    type: str = "*"
    md5sum: str = "*"
    failure: Failure | None = None
    definition: str = ""
    extra_bytes: int = 0
    latched: bool = False


@dataclass
class System:
    """Facts about a running system.

    Attributes:
        master_uri: the master's URI in this shell.
        state: the registered publishers, subscribers and service providers.
        nodes: the nodes by name.
        services: for each service, its provider's URI, and the reason why the provider did not respond or None.
        publications, subscriptions: the types that publishers and subscribers report. Only those that may reveal a
            problem are queried. Subscribers report only the name of the type.
        use_sim_time: whether the parameter /use_sim_time is true.
        bridges: the statuses of the bridges that respond, by the names of their nodes.
    """

    master_uri: str
    state: SystemState
    nodes: Mapping[str, NodeFacts]
    services: Mapping[str, tuple[str, Failure | None]] = field(default_factory=dict)
    publications: Mapping[TopicParticipant, ReportedType] = field(default_factory=dict)
    subscriptions: Mapping[TopicParticipant, ReportedType] = field(default_factory=dict)
    use_sim_time: bool = False
    bridges: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
