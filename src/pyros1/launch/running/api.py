"""The launcher's XML-RPC API (X92), for tools such as roswtf."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from typing import Any

from pyros1.ground.errors import LaunchError
from pyros1.launch.running.process import Process
from pyros1.launch.running.supervisor import Supervisor
from pyros1.launch.running.usage import group_usages
from pyros1.net.hosts import LocalAddress
from pyros1.net.loop import Loop
from pyros1.net.xmlrpc_server import XmlRpcServer, unknown_method

Triple = list[Any]


class LaunchServer:
    """Answers questions about a launch.

    Args:
        supervisor: supervisor of the launch's processes.
        address: addresses to listen on and to advertise.
    """

    def __init__(self, supervisor: Supervisor, address: LocalAddress) -> None:
        self._supervisor = supervisor
        self._loop = Loop("roslaunch")
        self._server = XmlRpcServer(
            self._loop, self.dispatch, bind_host=address.bind, advertised_host=address.advertised
        )
        self._loop.start()

    @property
    def uri(self) -> str:
        """The API's URI."""
        return self._server.uri

    def param_name(self) -> str:
        """Return the parameter that publishes the URI (X81): ``/roslaunch/uris/host_<host>__<port>``."""
        host = self.uri.removeprefix("http://").rstrip("/").rpartition(":")[0]
        safe = "".join(char if char.isalnum() else "_" for char in host)
        return f"/roslaunch/uris/host_{safe}__{self._server.port}"

    def close(self) -> None:
        """Stop answering."""
        self._server.close()
        self._loop.stop()

    def dispatch(self, method: str, params: Sequence[Any]) -> Triple:
        """Return the answer to a call, ``[code, message, value]``."""
        answers: dict[str, Callable[[Sequence[Any]], Triple]] = {
            "get_pid": lambda _: [1, "", os.getpid()],
            "list_processes": self._list_processes,
            "get_node_names": lambda _: [
                1,
                "node names",
                [process.spec.node for process in self._supervisor.active],
            ],
            "list_children": lambda _: [1, "roslaunch children", []],
            "process_info": self._process_info,
            "status": lambda _: [1, "processes", self._status()],
            "control": self._control,
        }
        if method not in answers:
            raise unknown_method(method)
        return answers[method](params)

    def _list_processes(self, params: Sequence[Any]) -> Triple:
        lists = [_counts(self._supervisor.active), _counts(self._supervisor.dead)]
        return [1, "processes on parent machine", lists]

    def _status(self) -> list[dict[str, Any]]:
        usages = group_usages()
        now = time.monotonic()
        entries = []
        for process in [*self._supervisor.active, *self._supervisor.dead]:
            usage = process.usage(usages)
            entry: dict[str, Any] = {
                "label": process.spec.label,
                "node": process.spec.node,
                "state": _state(process, process in self._supervisor.dead),
                "pid": process.pid,
                "starts": process.spawn_count,
                "uptime": now - process.started if process.alive else -1.0,
                "cpu": usage.cpu,
                # XML-RPC's integers have 32 bits.
                "memory": float(usage.memory),
                "machine": process.machine,
            }
            if process.exit_code is not None:
                entry["exit_code"] = process.exit_code
            entries.append(entry)
        return entries

    def _control(self, params: Sequence[Any]) -> Triple:
        supervisor = self._supervisor
        verbs = {"stop": supervisor.stop_node, "start": supervisor.start_node, "restart": supervisor.restart_node}
        if len(params) != 2 or params[0] not in verbs:
            return [-1, "control needs one of stop, start and restart, and a node name", 0]
        try:
            process = supervisor.find(str(params[1]))
        except LaunchError as error:
            return [-1, str(error), 0]
        supervisor.do(lambda: verbs[params[0]](process))
        return [1, f"will {params[0]} {process.spec.label}", 1]

    def _process_info(self, params: Sequence[Any]) -> Triple:
        name = params[0] if params else None
        for process in [*self._supervisor.active, *self._supervisor.dead]:
            if process.spec.label == name:
                info: dict[str, Any] = {
                    "spawn_count": process.spawn_count,
                    "name": process.spec.label,
                    "alive": process.alive,
                    "respawn": process.spec.respawn,
                    "required": process.spec.required,
                    "pid": process.pid,
                    "args": " ".join(process.spec.words),
                    "cwd": process.spec.cwd,
                    "env": process.spec.env,
                    "log_file": f"{process.spec.log_base}*.log" if process.spec.log_base else "",
                }
                if process.exit_code is not None:
                    info["exit_code"] = process.exit_code
                return [1, "process info", info]
        return [-1, f"no process by that name: {name}", {}]


def _state(process: Process, over: bool) -> str:
    if process.alive:
        return "stopping" if process.held or process.restarting else "running"
    if process.held:
        return "stopped"
    if over:
        return "died" if process.exit_code else "finished"
    return "waiting"


def _counts(processes: list[Process]) -> list[list[Any]]:
    return [[process.spec.label, process.spawn_count] for process in processes]
