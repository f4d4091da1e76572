"""The invocation of a command: its arguments, and the names, master and node derived from them.

This module only imports what every command needs, so that commands start quickly.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from pyros1.ground import names, terminal_text

if TYPE_CHECKING:
    from pyros1.graph import Graph
    from pyros1.net.master_client import MasterClient
    from pyros1.node import Node

MASTER_TIMEOUT = 5.0
"""Timeout for the master's responses in seconds."""


def called_as(name: str) -> bool:
    """Return whether this program was called by a stock tool's name, such as ``rostopic``."""
    return bool(sys.argv) and os.path.basename(sys.argv[0]) == name != ""


class Invocation:
    """The invocation of a command: its arguments without remappings, and the names and master derived from them (N11).

    Args:
        command: the command's name.
        stock: the stock tool's name, such as ``rostopic``; empty if there is no such tool.
        argv: the arguments after the command's name, starting with the verb if the command has verbs.
        with_verb: whether the command has verbs.
        environ: the environment variables; None for those of the process.

    Attributes:
        tool: the base name of the command's node, which is the stock tool's name.
        program: the name by which the user called the command: ``rostopic`` or ``pyros1 topic``.
        as_stock: whether the command was called by the stock tool's name.
        verb: the first argument if the command has verbs.
        args: the arguments without the verb and remappings.
        argv: the arguments as given, with the verb and remappings.
        special: the values of arguments such as ``__name:=x``, by name with the leading ``__``.
        remapping_args: the remappings, including those in ``special``.
        environ: the environment variables.
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
        self.as_stock = called_as(stock)
        self.program = stock if self.as_stock else f"pyros1 {command}"
        self.argv = argv
        self.verb = arguments.rest[0] if with_verb and arguments.rest else ""
        self.args = arguments.rest[1:] if with_verb else arguments.rest
        self.special = arguments.special
        self.remapping_args = [arg for arg in argv if arg not in arguments.rest]
        namespace = arguments.special.get("__ns") or self.environ.get("ROS_NAMESPACE") or names.SEP
        self._namespace = names.SEP + namespace.strip(names.SEP)
        self._master: MasterClient | None = None
        self._wait_for_shutdown: Callable[[float], bool]  # set by open_node

    def resolve(self, name: str) -> str:
        """Return the full name for a name on the command line. The master checks the name; this method does not."""
        if names.is_private(name):
            return terminal_text.untrusted(names.canonicalize_name(f"{self._namespace}/{self.tool}/{name[1:]}"))
        return terminal_text.untrusted(names.canonicalize_name(names.ns_join(self._namespace, name)))

    @property
    def namespace(self) -> str:
        """The namespace of relative names (default ``/``)."""
        return self._namespace

    @property
    def caller_id(self) -> str:
        """The name with which the command identifies itself in calls to the master and to nodes."""
        return f"/{self.tool}-{os.getpid()}" if self.tool == "rosparam" else f"/{self.tool}"

    @property
    def master(self) -> MasterClient:
        """A client for the master, created when this property is first used."""
        if self._master is None:
            from pyros1.net.hosts import master_uri  # noqa: PLC0415
            from pyros1.net.master_client import MasterClient  # noqa: PLC0415

            uri = master_uri(self.environ, self.special)
            self._master = MasterClient(self.caller_id, uri, timeout=MASTER_TIMEOUT)
        return self._master

    def close(self) -> None:
        """Close the connection to the master if it was opened."""
        if self._master is not None:
            self._master.close()
            self._master = None

    @property
    def graph(self) -> Graph:
        """A new object that queries the running system."""
        from pyros1.graph import Graph  # noqa: PLC0415

        return Graph(self.master)

    def open_node(self) -> Node:
        """Create and return a node for this command, with an anonymous name like the stock tool's (L05).

        Raises:
            MasterUnreachableError: no master is running. Unlike other nodes, commands do not wait for one.
        """
        self.master.ping()  # fail before slow imports if no master is running
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
        has_shut_down = Event()
        node.on_shutdown(has_shut_down.set)
        self._wait_for_shutdown = has_shut_down.wait
        return node

    def pause(self, seconds: float) -> bool:
        """Wait for some wall-clock seconds. Return True, or False as soon as the node from `open_node` shuts down."""
        return not self._wait_for_shutdown(seconds)
