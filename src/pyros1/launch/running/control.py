"""Access to running launches: list their processes, and stop, start or restart one.

Every launch publishes its address in a parameter below ``/roslaunch/uris`` (X81). Stock launches do so as well; they
report the state of their processes, but cannot be controlled. The answers may come from any program, so their structure
is checked and their size is bounded.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import isfinite
from typing import Any

from pyros1.ground.errors import Error, LaunchError, MasterError, ParameterNotSetError, ProtocolError, XmlRpcFault
from pyros1.launch.running.usage import UNKNOWN, age, group_usages, launch_files
from pyros1.net.hosts import is_local, parse_uri
from pyros1.net.master_client import MasterClient, unpack
from pyros1.net.xmlrpc_client import XmlRpcClient

URIS = "/roslaunch/uris"
STATES = ("running", "waiting", "stopping", "stopped", "finished", "died", "ended")
_TIMEOUT = 5.0
_MAX_PROCESSES = 2_000
_MAX_QUERIED = 200
"""Maximum number of processes of a stock launch that are queried one by one."""
_MAX_TEXT_LENGTH = 1_000
"""Maximum number of characters of a text."""
_STOCK = "this is a stock roslaunch, which reports the state of its nodes, but cannot stop or start them"


@dataclass(frozen=True)
class Status:
    """One process of a launch.

    Attributes:
        label: its name in the launch.
        node: the node's full name.
        state: ``running``, ``waiting`` (for its respawn), ``stopping``, ``stopped`` (by the
            user), ``finished``, ``died``, or ``ended`` (with an unknown result).
        pid: process id, 0 if it never ran.
        starts: how often it was started.
        uptime: seconds since the last start, negative if it is not running or this is unknown.
        cpu: CPU time used so far in seconds, negative if unknown.
        memory: resident memory in bytes, negative if unknown.
        machine: name of its machine, empty for the machine of its launch.
        exit_code: exit code, None while it is running or if unknown.
        required: whether its launch ends when it ends.
        respawn: whether it is started again whenever it ends.
        log: path of its log files without ``.log``, empty for none.
    """

    label: str
    node: str
    state: str
    pid: int
    starts: int
    uptime: float = -1.0
    cpu: float = -1.0
    memory: int = -1
    machine: str = ""
    exit_code: int | None = None
    required: bool = False
    respawn: bool = False
    log: str = ""


@dataclass(frozen=True)
class Report:
    """A launch and its processes at one moment.

    Attributes:
        title: names of its files, or another description.
        pid: its process id.
        uptime: seconds since it began, negative if unknown.
        expected: number of nodes that are waiting for their first start.
        refusal: why we may not stop and start its processes; empty if we may.
        processes: its processes, in the order of their start.
    """

    title: str
    pid: int
    uptime: float = -1.0
    expected: int = 0
    refusal: str = ""
    processes: list[Status] = field(default_factory=list)


class Launch:
    """A running launch.

    Args:
        uri: URI of its API.
        timeout: seconds that a call may take.

    Raises:
        ProtocolError: the URI is not valid.
    """

    def __init__(self, uri: str, timeout: float = _TIMEOUT) -> None:
        self.uri = uri
        self._client = XmlRpcClient(uri, timeout=timeout)

    def _call(self, method: str, *params: Any) -> Any:
        return unpack(self._client.call(method, *params), f"the launch at {self.uri}, called with {method},")

    def report(self) -> Report:
        """Return its state.

        Raises:
            Error: the launch does not answer, or its answer is malformed.
        """
        try:
            answer = self._call("status")
        except XmlRpcFault:
            return self._stock_report()
        try:
            summary = answer["launch"]
            return Report(
                title=_text(summary["title"]),
                pid=int(summary["pid"]),
                uptime=_seconds(summary["uptime"]),
                expected=int(summary["expected"]),
                refusal=_text(summary["refusal"]),
                processes=[_status(entry) for entry in answer["processes"][:_MAX_PROCESSES]],
            )
        except (AttributeError, KeyError, TypeError, ValueError, OverflowError):
            raise ProtocolError(f"{self.uri} is not the address of a launch") from None

    def status(self) -> list[Status]:
        """Return its processes, in the order of their start.

        Raises:
            Error: as `report`.
        """
        return self.report().processes

    def _stock_report(self) -> Report:
        pid_here = is_local(parse_uri(self.uri)[0])
        usages = group_usages() if pid_here else {}
        try:
            active, dead = self._call("list_processes")
            pid = int(self._call("get_pid"))
            entries = [(_text(label), int(count), True) for label, count in active]
            entries += [(_text(label), int(count), False) for label, count in dead]
        except (TypeError, ValueError, OverflowError):
            raise ProtocolError(f"{self.uri} is not the address of a launch") from None
        processes = []
        for number, (label, count, running) in enumerate(entries[:_MAX_PROCESSES]):
            info = self.info(label) if number < _MAX_QUERIED else {}
            entry = stock_status(label, count, running, info)
            if pid_here and entry.state == "running":
                usage = usages.get(entry.pid, UNKNOWN)
                entry = replace(entry, cpu=usage.cpu, memory=usage.memory, uptime=age(entry.pid))
            processes.append(entry)
        title = _text(launch_files(pid)) if pid_here else ""
        return Report(title or "a stock roslaunch", pid, age(pid) if pid_here else -1.0, 0, _STOCK, processes)

    def info(self, label: str) -> Mapping[str, Any]:
        """Return further facts about a process: ``args``, ``cwd`` and more, as reported by the launch.

        Raises:
            UnreachableError: the launch does not answer.
            DeadlineError: it does not answer in time.
        """
        try:
            info = self._call("process_info", label)
        except (XmlRpcFault, MasterError, ProtocolError):
            return {}  # stock does not know dead processes, and fails for the master
        return info if isinstance(info, dict) else {}

    def request(self, verb: str, node: str) -> None:
        """Tell the launch to stop, start or restart a node. Do not wait until it is done.

        Args:
            verb: ``stop``, ``start`` or ``restart``.
            node: the node's full name, or its label.

        Raises:
            Error: the launch cannot do that, or refuses.
        """
        try:
            self._call("control", verb, node)
        except XmlRpcFault as error:
            raise LaunchError(f"the launch of {node} cannot {verb} it: {_STOCK}") from error

    def close(self) -> None:
        """Close the connection."""
        self._client.close()


def _status(entry: Mapping[str, Any]) -> Status:
    exit_code = entry.get("exit_code")
    state = entry["state"]
    return Status(
        label=_text(entry["label"]),
        node=_text(entry["node"]),
        state=state if state in STATES else "died",
        pid=int(entry["pid"]),
        starts=int(entry["starts"]),
        uptime=_seconds(entry.get("uptime", -1.0)),
        cpu=_seconds(entry.get("cpu", -1.0)),
        memory=int(entry.get("memory", -1)),
        machine=_text(entry.get("machine", "")),
        exit_code=None if exit_code is None else int(exit_code),
        required=bool(entry.get("required")),
        respawn=bool(entry.get("respawn")),
        log=_text(entry.get("log", "")),
    )


def stock_status(label: str, starts: int, active: bool, info: Mapping[str, Any]) -> Status:
    """Return the status of a process of a stock launch.

    Args:
        label: its name in the launch.
        starts: how often it was started.
        active: whether it is running or may run again.
        info: the launch's answer to ``process_info``; empty if none.
    """
    args = info.get("args")
    words = [word for word in args if isinstance(word, str)] if isinstance(args, list) else []
    environ = info.get("env")
    arguments = {word[:3]: word.partition(":=")[2] for word in words if word.startswith(("__name:=", "__log:="))}
    namespace = str(environ.get("ROS_NAMESPACE", "")).strip("/") if isinstance(environ, dict) else ""
    name = arguments.get("__n") or label.rpartition("/")[2].rpartition("-")[0] or label
    if not words:
        namespace = label.rpartition("/")[0]
    running = active and info.get("alive", True) is not False
    exit_code = _number(info["exit_code"], None) if "exit_code" in info else None
    state = "died" if exit_code else "ended" if exit_code is None else "finished"
    if running or (active and info.get("respawn") is True):
        state = "running" if running else "waiting"
    return Status(
        label=label,
        node=_text(f"/{namespace}/{name}" if namespace else f"/{name}"),
        state=state,
        pid=_number(info.get("pid"), 0),
        starts=starts,
        exit_code=None if running else exit_code,
        required=info.get("required") is True,
        respawn=info.get("respawn") is True,
        log=_text(arguments.get("__l", "").removesuffix(".log")),
    )


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError("not a text")
    return value if len(value) <= _MAX_TEXT_LENGTH else f"{value[:_MAX_TEXT_LENGTH]}..."


def _seconds(value: Any) -> float:
    seconds = float(value)
    if not isfinite(seconds):
        raise ValueError("not a time")
    return seconds


def _number(value: Any, default: Any) -> Any:
    return value if isinstance(value, int) and not isinstance(value, bool) else default


def launch_uris(master: MasterClient) -> dict[str, str]:
    """Return the URIs of the launches of a system by the names of their parameters; some launches may have ended.

    Args:
        master: the system's master.

    Raises:
        MasterError: the master refuses, or does not answer.
    """
    try:
        uris = master.get_param(URIS)
    except ParameterNotSetError:
        return {}
    return (
        {f"{URIS}/{name}": uri for name, uri in uris.items() if isinstance(uri, str)} if isinstance(uris, dict) else {}
    )


def running_launches(master: MasterClient) -> list[tuple[Launch, list[Status]]]:
    """Return the running launches of a system, each with its processes. The caller must close them.

    Args:
        master: the system's master.
    """
    found = []
    for uri in sorted(set(launch_uris(master).values())):
        try:
            launch = Launch(uri)
        except ProtocolError:
            continue
        try:
            found.append((launch, launch.status()))
        except Error:
            launch.close()  # it was killed, and only its parameter is left
    return found
