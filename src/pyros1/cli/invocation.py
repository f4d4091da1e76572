"""One run of a command: its words, and the names, the master and the node that these give.

Only what every command needs is imported here: listing topics must stay quick.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from pyros1 import names, shown

if TYPE_CHECKING:
    from pyros1.graph import Graph
    from pyros1.net.master_client import MasterClient
    from pyros1.node import Node

MASTER_TIMEOUT = 5.0
"""Seconds that a command gives the master for an answer."""


class Invocation:
    """One run of a command: its arguments without the remappings, and the names and the master that those give (N11).

    Args:
        command: its name.
        stock: the stock tool's name, for example ``rostopic``; empty if there is none.
        argv: arguments after the command's name, the verb first if it has verbs.
        with_verb: it has verbs.
        environ: environment variables; None takes the process's.

    Attributes:
        tool: the name that the command's node has, that of the stock tool.
        program: how the user called the command: ``rostopic`` under that name, else ``pyros1 topic``.
        as_stock: it was called by the stock tool's name.
        verb: the first argument, of a command with verbs.
        args: the arguments, but for the verb and remappings.
        special: remappings whose names begin with ``__``.
    """

    def __init__(
        self,
        command: str,
        stock: str,
        argv: list[str],
        *,
        with_verb: bool = True,
        environ: Mapping[str, str] | None = None,
    ) -> None:
        self.environ = os.environ if environ is None else environ
        arguments = names.parse_arguments(argv)
        self.tool = stock or f"ros{command}"
        self.as_stock = bool(sys.argv) and os.path.basename(sys.argv[0]) == stock != ""
        self.program = stock if self.as_stock else f"pyros1 {command}"
        self.argv = argv
        self.verb = arguments.rest[0] if with_verb and arguments.rest else ""
        self.args = arguments.rest[1:] if with_verb else arguments.rest
        self.special = arguments.special
        self.remapping_args = [arg for arg in argv if arg not in arguments.rest]
        ns = arguments.special.get("__ns") or self.environ.get("ROS_NAMESPACE") or names.SEP
        self._namespace = names.SEP + ns.strip(names.SEP)
        self._master: MasterClient | None = None
        self._wait: Callable[[float], bool]  # set by open_node

    def resolve(self, name: str) -> str:
        """Return the full name that a name on the command line stands for. Legal or not is the master's business."""
        if names.is_private(name):
            return shown.foreign(names.canonicalize_name(f"{self._namespace}/{self.tool}/{name[1:]}"))
        return shown.foreign(names.canonicalize_name(names.ns_join(self._namespace, name)))

    @property
    def namespace(self) -> str:
        """The namespace of relative names, ``/`` if none was given."""
        return self._namespace

    @property
    def caller_id(self) -> str:
        """The name under which the tool speaks to master and nodes."""
        return f"/{self.tool}-{os.getpid()}" if self.tool == "rosparam" else f"/{self.tool}"

    @property
    def master(self) -> MasterClient:
        """The master of this system."""
        if self._master is None:
            from pyros1.net.hosts import master_uri  # noqa: PLC0415
            from pyros1.net.master_client import MasterClient  # noqa: PLC0415

            uri = master_uri(self.environ, self.special)
            self._master = MasterClient(self.caller_id, uri, timeout=MASTER_TIMEOUT)
        return self._master

    def close(self) -> None:
        """Close the connection to the master, if there is one."""
        if self._master is not None:
            self._master.close()
            self._master = None

    @property
    def graph(self) -> Graph:
        """Questions about this system."""
        from pyros1.graph import Graph  # noqa: PLC0415

        return Graph(self.master)

    def open_node(self) -> Node:
        """A node for this command, with an anonymous name as the stock tool's (L05).

        Raises:
            MasterUnreachableError: the master is not there; tools do not wait for it.
        """
        self.master.ping()  # says at once, before anything heavy is imported, if there is no master
        from threading import Event  # noqa: PLC0415

        from pyros1.node import Node  # noqa: PLC0415

        node = Node(
            self.tool,
            anonymous=True,
            argv=self.remapping_args,
            environ=self.environ,
            rosout=False,
            wait_for_master=0.0,
            log_level="warn",
        )
        ended = Event()
        node.on_shutdown(ended.set)
        self._wait = ended.wait
        return node

    def pause(self, seconds: float) -> bool:
        """Wait in wall time; returns False, at once, when the command's node ends."""
        return not self._wait(seconds)
