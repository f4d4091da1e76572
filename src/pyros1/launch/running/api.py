"""The launcher's XML-RPC API (X92), for tools such as roswtf; ``status`` and ``control`` are extensions of pyros1.

Any client may query the launch. ``control`` stops and starts nodes exactly as the launch file describes them, so it
never runs anything else. It is restricted to callers that could also send signals to the processes (see `callers`).
Only they can read the environment of a process, which often contains secrets.
"""

from __future__ import annotations

import os
import socket
import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import LaunchError
from pyros1.launch.running.callers import refusal_reason
from pyros1.launch.running.process import Process
from pyros1.launch.running.supervisor import Supervisor
from pyros1.launch.running.usage import Usage, group_usages
from pyros1.net.hosts import LocalAddress
from pyros1.net.loop import Loop
from pyros1.net.xmlrpc_server import XmlRpcServer, make_unknown_method_fault

if TYPE_CHECKING:
    from pyros1.net.allowlist import Allowlist

Response = list[Any]
"""[code, message, value], as for all XML-RPC methods of ROS."""


class LaunchServer:
    """An XML-RPC server through which other programs query and control a launch.

    Args:
        supervisor: supervisor of the launch's processes.
        address: addresses to listen on and to advertise.
        title: readable title of the launch, such as the names of its files.
        check_caller: returns the reason why a caller may not control the launch, or an empty string if the caller may.
        allowlist: decides which hosts may connect; None admits all.
    """

    def __init__(
        self,
        supervisor: Supervisor,
        address: LocalAddress,
        title: str = "roslaunch",
        check_caller: Callable[[socket.socket], str] = refusal_reason,
        allowlist: Allowlist | None = None,
    ) -> None:
        self._supervisor = supervisor
        self._title = title
        self._check_caller = check_caller
        self._started_at = time.monotonic()
        self._loop = Loop("roslaunch")
        self._server = XmlRpcServer(
            self._loop,
            self.dispatch,
            bind_host=address.bind,
            advertised_host=address.advertised,
            ports=address.ports,
            allowlist=allowlist,
        )
        self._loop.start()

    @property
    def uri(self) -> str:
        """The API's URI."""
        return self._server.uri

    def param_name(self) -> str:
        """Return the name of the parameter that contains the URI (X81): ``/roslaunch/uris/host_<host>__<port>``."""
        host = self.uri.removeprefix("http://").rstrip("/").rpartition(":")[0]
        escaped_host = "".join(char if char.isalnum() else "_" for char in host)
        return f"/roslaunch/uris/host_{escaped_host}__{self._server.port}"

    def close(self) -> None:
        """Stop the server."""
        self._server.close()
        self._loop.stop()

    def dispatch(self, method: str, params: Sequence[Any]) -> Response:
        """Execute a call and return ``[code, message, value]``.

        Raises:
            XmlRpcFault: the method is unknown.
        """
        methods: dict[str, Callable[[Sequence[Any]], Response]] = {
            "get_pid": lambda _: [1, str(os.getpid()), os.getpid()],
            "list_processes": self._list_processes,
            "get_node_names": lambda _: [1, "node names", [process.spec.label for process in self._supervisor.active]],
            "list_children": lambda _: [1, "roslaunch children", []],
            "process_info": self._process_info,
            "status": self._status,
            "control": self._control,
        }
        if method not in methods:
            raise make_unknown_method_fault(method)
        return methods[method](params)

    def _list_processes(self, params: Sequence[Any]) -> Response:
        lists = [_spawn_counts(self._supervisor.active), _spawn_counts(self._supervisor.dead)]
        return [1, "processes on parent machine", lists]

    def _status(self, params: Sequence[Any]) -> Response:
        usages = group_usages()
        now = time.monotonic()
        dead = self._supervisor.dead
        entries = [
            _describe_process(process, process.usage(usages), now, has_ended=process in dead)
            for process in [*self._supervisor.active, *dead]
        ]
        launch = {
            "title": self._title,
            "pid": os.getpid(),
            "uptime": now - self._started_at,
            "expected": self._supervisor.num_expected,
            "refusal": self._refusal_reason(),
        }
        return [1, "status", {"launch": launch, "processes": entries}]

    def _refusal_reason(self) -> str:
        caller_socket = self._server.caller_socket
        return "" if caller_socket is None else self._check_caller(caller_socket)

    def _control(self, params: Sequence[Any]) -> Response:
        supervisor = self._supervisor
        verbs = {"stop": supervisor.stop_node, "start": supervisor.start_node, "restart": supervisor.restart_node}
        if len(params) != 2 or params[0] not in [*verbs]:  # compared with a list, since the value may be unhashable
            return [-1, "control needs one of stop, start and restart, and a node name", 0]
        if reason := self._refusal_reason():
            return [-1, reason, 0]
        try:
            process = supervisor.find(str(params[1]))
        except LaunchError as error:
            return [-1, str(error), 0]
        supervisor.call_soon(lambda: verbs[params[0]](process))
        return [1, f"will {params[0]} {process.spec.label}", 1]

    def _process_info(self, params: Sequence[Any]) -> Response:
        name = params[0] if params else None
        for process in [*self._supervisor.active, *self._supervisor.dead]:
            if process.spec.label == name:
                spec = process.spec
                info: dict[str, Any] = {
                    "spawn_count": process.spawn_count,
                    "name": spec.label,
                    "alive": process.alive,
                    "respawn": spec.exit_policy.respawn,
                    "respawn_delay": float(spec.exit_policy.respawn_delay),
                    "required": spec.exit_policy.required,
                    "pid": process.pid,
                    "args": spec.words,
                    "cwd": spec.cwd,
                    "env": {} if self._refusal_reason() else spec.env,
                    "log_output": not spec.to_screen,
                    "log_file": f"{spec.log_base}*.log" if spec.log_base else "",
                }
                if process.exit_code is not None:
                    info["exit_code"] = process.exit_code
                return [1, "process info", info]
        return [-1, f"no process by that name: {name}", {}]


def _describe_process(process: Process, usage: Usage, now: float, *, has_ended: bool) -> dict[str, Any]:
    spec = process.spec
    entry: dict[str, Any] = {
        "label": spec.label,
        "node": spec.node,
        "state": _state(process, has_ended),
        "pid": process.pid,
        "starts": process.spawn_count,
        "uptime": now - process.started_at if process.alive else -1.0,
        "cpu": usage.cpu,
        # XML-RPC's integers have 32 bits.
        "memory": float(usage.memory),
        "machine": process.machine,
        "required": spec.exit_policy.required,
        "respawn": spec.exit_policy.respawn,
        "log": spec.log_base or "",
    }
    if process.exit_code is not None:
        entry["exit_code"] = process.exit_code
    return entry


def _state(process: Process, has_ended: bool) -> str:
    if process.alive:
        return "stopping" if process.stopped_by_user or process.is_restarting else "running"
    if process.stopped_by_user:
        return "stopped"
    if has_ended:
        return "died" if process.exit_code else "finished"
    return "waiting"


def _spawn_counts(processes: list[Process]) -> list[list[Any]]:
    return [[process.spec.label, process.spawn_count] for process in processes]
