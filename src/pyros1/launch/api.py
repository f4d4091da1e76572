"""The launcher's XML-RPC interface (X92): what tools such as roswtf ask a running launch."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

from pyros1.launch.process import Process
from pyros1.launch.supervisor import Supervisor
from pyros1.net.hosts import LocalAddress
from pyros1.net.loop import Loop
from pyros1.net.xmlrpc_server import XmlRpcServer, unknown_method

Triple = list[Any]


class LaunchServer:
    """Answers questions about a launch.

    Args:
        supervisor: whose processes are meant.
        address: where to listen and what to advertise.
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
        """Where it listens."""
        return self._server.uri

    def param_name(self) -> str:
        """The parameter that tells the world about it (X81): ``/roslaunch/uris/host_<host>__<port>``."""
        host = self.uri.removeprefix("http://").rstrip("/").rpartition(":")[0]
        safe = "".join(char if char.isalnum() else "_" for char in host)
        return f"/roslaunch/uris/host_{safe}__{self._server.port}"

    def close(self) -> None:
        """Stop answering."""
        self._server.close()
        self._loop.stop()

    def dispatch(self, method: str, params: Sequence[Any]) -> Triple:
        """Answer one call with a triple ``[code, message, value]``."""
        if method == "get_pid":
            return [1, "", os.getpid()]
        if method == "list_processes":
            return [
                1,
                "processes on parent machine",
                [_counts(self._supervisor.active), _counts(self._supervisor.dead)],
            ]
        if method == "get_node_names":
            return [1, "node names", [process.spec.node for process in self._supervisor.active]]
        if method == "list_children":
            return [1, "roslaunch children", []]
        if method == "process_info":
            return self._process_info(params)
        raise unknown_method(method)

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


def _counts(processes: list[Process]) -> list[list[Any]]:
    return [[process.spec.label, process.spawn_count] for process in processes]
