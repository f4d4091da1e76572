"""Access to running launches: list their processes, and stop, start or restart one.

Every launch publishes its address in a parameter below ``/roslaunch/uris`` (X81). Stock launches do, too, but they only
report names and process ids.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

from pyros1.ground.errors import Error, LaunchError, ParameterNotSetError, XmlRpcFault
from pyros1.net.master_client import MasterClient, unpack
from pyros1.net.xmlrpc_client import XmlRpcClient

URIS = "/roslaunch/uris"
_TIMEOUT = 5.0


@dataclass(frozen=True)
class Status:
    """One process of a launch.

    Attributes:
        label: its name in the launch.
        node: the node's full name.
        state: ``running``, ``waiting`` (for its respawn), ``stopping``, ``stopped`` (by the
            user), ``finished`` or ``died``.
        pid: process id, 0 if it never ran.
        starts: how often it was started.
        uptime: seconds since the last start, negative if it does not run.
        cpu: CPU time used so far in seconds, negative if unknown.
        memory: resident memory in bytes, negative if unknown.
        machine: name of its machine, empty for the machine of its launch.
        exit_code: exit code, None while it runs.
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


class Launch:
    """A running launch.

    Args:
        uri: URI of its API.
    """

    def __init__(self, uri: str) -> None:
        self.uri = uri
        self._client = XmlRpcClient(uri, timeout=_TIMEOUT)

    def _call(self, method: str, *params: Any) -> Any:
        return unpack(self._client.call(method, *params), f"the launch at {self.uri}, called with {method},")

    def status(self) -> list[Status]:
        """Return its processes, in the order of their start.

        Raises:
            Error: the launch does not answer.
        """
        try:
            return [_status(entry) for entry in self._call("status")]
        except XmlRpcFault:
            active, dead = self._call("list_processes")
        nodes = [(label, count, "running") for label, count in active]
        nodes += [(label, count, "died") for label, count in dead]
        return [
            Status(label, "/" + label.rpartition("-")[0], state, self._pid(label), int(count))
            for label, count, state in nodes
        ]

    def _pid(self, label: str) -> int:
        try:
            return int(self._call("process_info", label).get("pid", 0))
        except (Error, AttributeError, ValueError):
            return 0

    def tell(self, verb: str, node: str) -> None:
        """Tell the launch to stop, start or restart a node. Return before this is done.

        Args:
            verb: ``stop``, ``start`` or ``restart``.
            node: the node's full name.

        Raises:
            Error: the launch cannot do that.
        """
        try:
            self._call("control", verb, node)
        except XmlRpcFault as error:
            raise LaunchError(f"the launch of {node} is a stock roslaunch, which cannot {verb} nodes") from error

    def close(self) -> None:
        """Close the connection."""
        self._client.close()


def _status(entry: dict[str, Any]) -> Status:
    known = {field.name: entry[field.name] for field in fields(Status) if field.name in entry}
    return Status(**{**known, "memory": int(known.get("memory", -1))})


def running_launches(master: MasterClient) -> list[tuple[Launch, list[Status]]]:
    """Return the running launches of a system, each with its processes. The caller must close them.

    Args:
        master: the system's master.
    """
    try:
        uris = master.get_param(URIS)
    except ParameterNotSetError:
        return []
    found = []
    for uri in sorted(set(map(str, uris.values()))) if isinstance(uris, dict) else ():
        launch = Launch(uri)
        try:
            found.append((launch, launch.status()))
        except Error:
            launch.close()  # it was killed, and only its parameter is left
    return found
