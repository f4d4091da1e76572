"""What the collectors find and the checks judge."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from pyros1.graph import Connection, SystemState

UNRESOLVED, REFUSED, TIMEOUT, OTHER = "unresolved", "refused", "timeout", "other"
"""Why somebody cannot be reached: no such host name; nobody listens; nothing comes back; anything else."""


class Failure(NamedTuple):
    """Why a question was not answered.

    Attributes:
        kind: one of the four above.
        text: as the error says it.
    """

    kind: str
    text: str


class Disk(NamedTuple):
    """Room on the disk of a folder, in bytes."""

    folder: str
    free: int
    total: int
    writable: bool


class LocalProcess(NamedTuple):
    """A running ROS program of this machine, with what its environment says; empty texts where it says nothing."""

    pid: int
    name: str
    master_uri: str
    host: str


@dataclass
class Machine:
    """This machine and this shell.

    Attributes:
        environ: environment variables.
        hostname: the machine's own name.
        interfaces: addresses of its network interfaces.
        resolved: host name -> addresses, None if it cannot be resolved; for all names that matter.
        missing_paths: entries of ROS_PACKAGE_PATH that are no folders.
        disks: of the folders that are written to.
        log_folder: where logs are.
        log_size: bytes in it; a lower bound if there was no time to count.
        masters: URIs of masters that answer on this machine.
        processes: running ROS programs, as far as the system tells.
        python: version, for example ``(3, 11)``.
        launch_problems: of the launch files that were given.
        package_problems: of packages that cannot be used.
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


@dataclass
class NodeFacts:
    """A node that the master lists.

    Attributes:
        uri: of its API.
        host: of that URI.
        addresses: what the host resolves to here; None if it does not.
        failure: why it did not answer; None if it did.
        connections: its ``getBusInfo``.
        clock_offset: seconds that its machine's clock is ahead of ours, None where it does not tell.
    """

    uri: str
    host: str
    addresses: Sequence[str] | None = ()
    failure: Failure | None = None
    connections: Sequence[Connection] = ()
    clock_offset: float | None = None


class End(NamedTuple):
    """One end of a topic: which node."""

    topic: str
    node: str


class Offer(NamedTuple):
    """What a publisher sends or a subscriber wants, as it says itself.

    Attributes:
        type, md5sum: ``*`` is any.
        failure: why it did not say so.
    """

    type: str = "*"
    md5sum: str = "*"
    failure: Failure | None = None


@dataclass
class System:
    """A running system.

    Attributes:
        master_uri: as this shell knows it.
        state: who publishes, subscribes and provides what.
        nodes: by name.
        services: name -> (URI of its provider, why that did not answer or None).
        publications, subscriptions: what the ends say of their types; only those ends are asked for whom it matters.
            Subscribers tell their types' names only.
        use_sim_time: the parameter.
    """

    master_uri: str
    state: SystemState
    nodes: Mapping[str, NodeFacts]
    services: Mapping[str, tuple[str, Failure | None]] = field(default_factory=dict)
    publications: Mapping[End, Offer] = field(default_factory=dict)
    subscriptions: Mapping[End, Offer] = field(default_factory=dict)
    use_sim_time: bool = False
