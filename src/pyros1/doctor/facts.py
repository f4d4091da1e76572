"""The facts that collectors gather and checks judge."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from pyros1.graph import Connection, SystemState

UNRESOLVED, REFUSED, TIMEOUT, HANGS, OTHER = "unresolved", "refused", "timeout", "hangs", "other"
"""Why something cannot be reached: unknown host name, connection refused, timeout, it accepts connections but does not
answer, or another reason."""


class Failure(NamedTuple):
    """Why a request was not answered.

    Attributes:
        kind: one of the five above.
        text: the error's text.
    """

    kind: str
    text: str


class Disk(NamedTuple):
    """Space on the disk of a folder in bytes."""

    folder: str
    free: int
    total: int
    writable: bool


class LocalProcess(NamedTuple):
    """A running ROS program on this machine, with variables of its environment; empty strings for unset ones."""

    pid: int
    name: str
    master_uri: str
    host: str


@dataclass
class Machine:
    """This machine and this shell.

    Attributes:
        environ: environment variables.
        hostname: the machine's name.
        interfaces: addresses of its network interfaces.
        resolved: host name -> addresses, None if it cannot be resolved; for all relevant names.
        missing_paths: entries of ROS_PACKAGE_PATH that are not folders.
        disks: disks of the folders that ROS writes to.
        log_folder: folder of log files.
        log_size: its size in bytes; a lower bound if counting took too long.
        masters: URIs of masters that answer on this machine.
        processes: running ROS programs, as far as the system lists them.
        python: version, for example ``(3, 11)``.
        launch_problems: problems of the given launch files.
        package_problems: problems of unusable packages.
        setting_problems: variables of pyros1 with a value that keeps nodes from starting, and why.
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
    """A node that the master lists.

    Attributes:
        uri: URI of its API.
        host: host in that URI.
        addresses: addresses of the host as resolved here; None if it cannot be resolved.
        failure: why it did not answer; None if it did.
        connections: the result of ``getBusInfo``.
        clock_offset: how far its machine's clock is ahead of ours in seconds, None if unknown.
    """

    uri: str
    host: str
    addresses: Sequence[str] | None = ()
    failure: Failure | None = None
    connections: Sequence[Connection] = ()
    clock_offset: float | None = None


class TopicEnd(NamedTuple):
    """One end of a topic."""

    topic: str
    node: str


class ReportedType(NamedTuple):
    """The type that a publisher sends or a subscriber wants, as reported by that node.

    Attributes:
        type, md5sum: the type and its checksum; ``*`` means any.
        failure: why it did not report them; None if it did.
        definition: full text of the type's definition, if a publisher gave it.
        extra_bytes: number of bytes after the first message received while the publisher was queried; negative: this
            many are missing at its end.
    """

    type: str = "*"
    md5sum: str = "*"
    failure: Failure | None = None
    definition: str = ""
    extra_bytes: int = 0


@dataclass
class System:
    """A running system.

    Attributes:
        master_uri: the master's URI in this shell.
        state: publishers, subscribers and service providers, from the master.
        nodes: nodes by name.
        services: name -> (URI of its provider, why it did not answer or None).
        publications, subscriptions: the types that the ends report; only relevant ends are queried. Subscribers report
            type names only.
        use_sim_time: the parameter /use_sim_time.
    """

    master_uri: str
    state: SystemState
    nodes: Mapping[str, NodeFacts]
    services: Mapping[str, tuple[str, Failure | None]] = field(default_factory=dict)
    publications: Mapping[TopicEnd, ReportedType] = field(default_factory=dict)
    subscriptions: Mapping[TopicEnd, ReportedType] = field(default_factory=dict)
    use_sim_time: bool = False
