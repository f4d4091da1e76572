"""Controls running launches: lists their processes, and stops, starts or restarts them.

Every launch stores its URI in a parameter below ``/roslaunch/uris`` (X81). Stock launches do so as well; they report
the state of their processes, but cannot be controlled. Any program may answer at such a URI, so the structure of
responses is checked, and their size is limited.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import isfinite
from typing import Any

from pyros1.ground.errors import Error, LaunchError, MasterError, ParameterNotSetError, ProtocolError, XmlRpcFault
from pyros1.launch.running.usage import UNKNOWN_USAGE, group_usages, launch_files, process_age
from pyros1.net.hosts import is_local, parse_uri
from pyros1.net.master_client import MasterClient, unpack_reply
from pyros1.net.xmlrpc_client import XmlRpcClient

URIS_PARAM = "/roslaunch/uris"
PROCESS_STATES = ("running", "waiting", "stopping", "stopped", "finished", "died", "ended")
_TIMEOUT = 5.0
MAX_PROCESSES = 2_000
"""Maximum number of processes of a launch that are reported."""
MAX_QUERIED = 200
"""Maximum number of processes that are queried one by one from a stock launch."""
_MAX_TEXT_LENGTH = 1_000
"""Maximum number of characters in a string from a response."""
_STOCK_REFUSAL = "this is a stock roslaunch, which reports the state of its nodes, but cannot stop or start them"


@dataclass(frozen=True)
class Status:
    """The status of a process in a launch.

    Attributes:
        label: the process's name in the launch.
        node: the node's full name.
        state: ``running``, ``waiting`` (to be respawned), ``stopping``, ``stopped`` (by the user), ``finished``,
            ``died``, or ``ended`` (with an unknown exit code).
        pid: the process id; 0 if it has never been started.
        starts: how many times it has been started.
        uptime: seconds since the last start; negative if it is not running or if unknown.
        cpu: CPU time used so far in seconds; negative if unknown.
        memory: resident memory in bytes; negative if unknown.
        machine: name of the process's machine; empty for the machine of the launch.
        exit_code: the exit code; None while it is running or if unknown.
        required: whether the launch is shut down when the process exits.
        respawn: whether the process is restarted whenever it exits.
        log: path of the log files without ``.log``; empty if there are none.
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
    """The state of a launch and its processes at one moment.

    Attributes:
        title: names of the launch files, or another description.
        pid: the launcher's process id.
        uptime: seconds since the launch was started; negative if unknown.
        expected: number of nodes that have not been started yet.
        refusal: the reason why this program may not stop and start the processes; empty if it may.
        processes: the processes, in the order in which they were started.
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
        uri: URI of the launch's API.
        timeout: maximum number of seconds for a call.

    Raises:
        ProtocolError: the URI is not valid.
    """

    def __init__(self, uri: str, timeout: float = _TIMEOUT) -> None:
        self.uri = uri
        self._client = XmlRpcClient(uri, timeout=timeout)

    def _call(self, method: str, *params: Any) -> Any:
        return unpack_reply(self._client.call(method, *params), f"the launch at {self.uri}, called with {method},")

    def report(self) -> Report:
        """Return the state of the launch and its processes.

        Raises:
            Error: the launch does not respond, or its response is malformed.
        """
        try:
            reply = self._call("status")
        except XmlRpcFault:
            return self._stock_report()
        try:
            summary = reply["launch"]
            return Report(
                title=_check_text(summary["title"]),
                pid=int(summary["pid"]),
                uptime=_check_seconds(summary["uptime"]),
                expected=int(summary["expected"]),
                refusal=_check_text(summary["refusal"]),
                processes=[_read_status(entry) for entry in reply["processes"][:MAX_PROCESSES]],
            )
        except (AttributeError, KeyError, TypeError, ValueError, OverflowError):
            raise ProtocolError(f"{self.uri} is not the address of a launch") from None

    def status(self) -> list[Status]:
        """Return the status of the processes, in the order in which they were started.

        Raises:
            Error: see `report`.
        """
        return self.report().processes

    def _stock_report(self) -> Report:
        is_on_this_machine = is_local(parse_uri(self.uri)[0])
        usages = group_usages() if is_on_this_machine else {}
        try:
            active, dead = self._call("list_processes")
            pid = int(self._call("get_pid"))
            entries = [(_check_text(label), int(count), True) for label, count in active]
            entries += [(_check_text(label), int(count), False) for label, count in dead]
        except (TypeError, ValueError, OverflowError):
            raise ProtocolError(f"{self.uri} is not the address of a launch") from None
        processes = []
        for index, (label, count, is_running) in enumerate(entries[:MAX_PROCESSES]):
            info = self.info(label) if index < MAX_QUERIED else {}
            entry = stock_status(label, count, is_running, info)
            if is_on_this_machine and entry.state == "running":
                usage = usages.get(entry.pid, UNKNOWN_USAGE)
                entry = replace(entry, cpu=usage.cpu, memory=usage.memory, uptime=process_age(entry.pid))
            processes.append(entry)
        title = _check_text(launch_files(pid)) if is_on_this_machine else ""
        return Report(
            title or "a stock roslaunch",
            pid,
            process_age(pid) if is_on_this_machine else -1.0,
            0,
            _STOCK_REFUSAL,
            processes,
        )

    def info(self, label: str) -> Mapping[str, Any]:
        """Return further information about a process, as reported by the launch: ``args``, ``cwd`` and more.

        Raises:
            UnreachableError: the launch does not respond.
            DeadlineError: the launch does not respond in time.
        """
        try:
            info = self._call("process_info", label)
        except (XmlRpcFault, MasterError, ProtocolError):
            return {}  # stock ROS has no information about dead processes, and raises a fault for the master
        return info if isinstance(info, dict) else {}

    def request(self, verb: str, node: str) -> None:
        """Ask the launch to stop, start or restart a node, without waiting until it has done so.

        Args:
            verb: ``stop``, ``start`` or ``restart``.
            node: the node's full name, or the process's label.

        Raises:
            Error: the launch does not respond, cannot do that, or refuses the request.
        """
        try:
            self._call("control", verb, node)
        except XmlRpcFault as error:
            raise LaunchError(f"the launch of {node} cannot {verb} it: {_STOCK_REFUSAL}") from error

    def close(self) -> None:
        """Close the connection."""
        self._client.close()


def _read_status(entry: Mapping[str, Any]) -> Status:
    exit_code = entry.get("exit_code")
    state = entry["state"]
    return Status(
        label=_check_text(entry["label"]),
        node=_check_text(entry["node"]),
        state=state if state in PROCESS_STATES else "died",
        pid=int(entry["pid"]),
        starts=int(entry["starts"]),
        uptime=_check_seconds(entry.get("uptime", -1.0)),
        cpu=_check_seconds(entry.get("cpu", -1.0)),
        memory=int(entry.get("memory", -1)),
        machine=_check_text(entry.get("machine", "")),
        exit_code=None if exit_code is None else int(exit_code),
        required=bool(entry.get("required")),
        respawn=bool(entry.get("respawn")),
        log=_check_text(entry.get("log", "")),
    )


def stock_status(label: str, starts: int, is_active: bool, info: Mapping[str, Any]) -> Status:
    """Return the status of a process in a stock launch.

    Args:
        label: the process's name in the launch.
        starts: how many times it has been started.
        is_active: whether it is running or may be respawned.
        info: the result of ``process_info``; empty if there is none.
    """
    args = info.get("args")
    words = [word for word in args if isinstance(word, str)] if isinstance(args, list) else []
    environ = info.get("env")
    arguments = {word[:3]: word.partition(":=")[2] for word in words if word.startswith(("__name:=", "__log:="))}
    namespace = str(environ.get("ROS_NAMESPACE", "")).strip("/") if isinstance(environ, dict) else ""
    name = arguments.get("__n") or label.rpartition("/")[2].rpartition("-")[0] or label
    if not words:
        namespace = label.rpartition("/")[0]
    is_running = is_active and info.get("alive", True) is not False
    exit_code = _int_or_default(info["exit_code"], None) if "exit_code" in info else None
    state = "died" if exit_code else "ended" if exit_code is None else "finished"
    if is_running or (is_active and info.get("respawn") is True):
        state = "running" if is_running else "waiting"
    return Status(
        label=label,
        node=_check_text(f"/{namespace}/{name}" if namespace else f"/{name}"),
        state=state,
        pid=_int_or_default(info.get("pid"), 0),
        starts=starts,
        exit_code=None if is_running else exit_code,
        required=info.get("required") is True,
        respawn=info.get("respawn") is True,
        log=_check_text(arguments.get("__l", "").removesuffix(".log")),
    )


def _check_text(value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError("not a string")
    return value if len(value) <= _MAX_TEXT_LENGTH else f"{value[:_MAX_TEXT_LENGTH]}..."


def _check_seconds(value: Any) -> float:
    seconds = float(value)
    if not isfinite(seconds):
        raise ValueError("not a finite number of seconds")
    return seconds


def _int_or_default(value: Any, default: Any) -> Any:
    return value if isinstance(value, int) and not isinstance(value, bool) else default


def launch_uris(master: MasterClient) -> dict[str, str]:
    """Return parameter name -> URI for a system's launches; some of the launches may have exited.

    Args:
        master: the client of the system's master.

    Raises:
        MasterError: the master refuses, or does not respond.
    """
    try:
        uris = master.get_param(URIS_PARAM)
    except ParameterNotSetError:
        return {}
    return (
        {f"{URIS_PARAM}/{name}": uri for name, uri in uris.items() if isinstance(uri, str)}
        if isinstance(uris, dict)
        else {}
    )


def running_launches(master: MasterClient) -> list[tuple[Launch, list[Status]]]:
    """Return a system's running launches, each with the status of its processes. The caller must close the launches.

    Args:
        master: the client of the system's master.
    """
    launches = []
    for uri in sorted(set(launch_uris(master).values())):
        try:
            launch = Launch(uri)
        except ProtocolError:
            continue
        try:
            launches.append((launch, launch.status()))
        except Error:
            launch.close()  # the launch was killed, and only its parameter is left
    return launches
