"""Nodes that stand in for other sites' nodes: they do nothing, but can be watched, listed and pinged like any node.

Each runs as long as the other site reports that its node is alive, and never takes a local node's name.
"""

from __future__ import annotations

import threading
from time import monotonic
from typing import NamedTuple

from pyros1.bridge.exchange.actions import RepresentNode
from pyros1.bridge.local_graph import STAND_IN_SERVICE
from pyros1.graph import Graph
from pyros1.ground.errors import Error, UnreachableError
from pyros1.ground.terminal_text import one_line
from pyros1.node import Node
from pyros1.node.log.levels import WARN

RETRY_PERIOD = 2.0
"""Seconds between attempts to start a node whose name is taken, or that the master refuses."""
MAX_STARTS = 10
"""Maximum number of nodes started at a time, whatever other sites request."""
_TIMEOUT = 1.0


class _Wanted(NamedTuple):
    action: RepresentNode
    serial: int


class _RunningNode(NamedTuple):
    node: Node
    serial: int


class StandIns:
    """The nodes that stand in for other sites' nodes.

    Args:
        node: the bridge's node.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._graph = Graph(node.master)
        self._lock = threading.Lock()
        self._wanted: dict[str, _Wanted] = {}
        self._running: dict[str, _RunningNode] = {}
        self._retry_at: dict[str, float] = {}
        self._serial = 0
        self._is_closing = False

    def note(self, action: RepresentNode) -> None:
        """Queue an action for `update`. Called in any thread."""
        with self._lock:
            if action.node:
                self._serial += 1
                self._wanted[action.local] = _Wanted(action, self._serial)
            else:
                self._wanted.pop(action.local, None)

    def update(self) -> None:
        """Start and end nodes, unless `close` was called. This waits for the master."""
        if self._is_closing:
            return
        with self._lock:
            wanted = dict(self._wanted)
        for local, (node, serial) in [*self._running.items()]:
            # A node that was lost and found again counts as a new process.
            if local not in wanted or wanted[local].serial != serial or not node.ok():
                self._end(local)
        self._retry_at = {local: at for local, at in self._retry_at.items() if local in wanted}
        now = monotonic()
        due = [local for local in wanted if local not in self._running and now >= self._retry_at.get(local, now)]
        for local in due[:MAX_STARTS]:
            self._retry_at[local] = now + RETRY_PERIOD
            node_or_none = self._start(wanted[local].action)
            if node_or_none is not None:
                self._running[local] = _RunningNode(node_or_none, wanted[local].serial)
            if self._is_closing:  # another thread called `close`, perhaps before the node was in `_running`
                self._end(local)
                return

    def _end(self, local: str) -> None:
        running = self._running.pop(local, None)
        if running is not None:
            running.node.shutdown("its node is gone")

    def _start(self, action: RepresentNode) -> Node | None:
        local, site, name = action
        text = f"{name} of site {site}"
        try:
            if not self._is_free(local):
                self._node.log.peer_event(WARN, "%s cannot be watched: there is a node %s here", one_line(text), local)
                return None
            namespace, _, base = local.rpartition("/")
            stand_in = Node(
                base,
                namespace=namespace or "/",
                argv=self._addresses(),
                master_uri=self._node.master_uri,
                environ=self._node.environ,
                handle_signals=False,
                rosout=False,
                log_services=False,  # the bridge may provide those of the original node
                wait_for_master=_TIMEOUT,
                wall_time=True,
            )
            try:
                stand_in.advertise_service(f"~{STAND_IN_SERVICE}", "std_srvs/Trigger", lambda _: (True, text))
            except BaseException:
                stand_in.shutdown()
                raise
        except Error as error:
            if self._node.ok():
                self._node.log.peer_event(WARN, "%s cannot be watched: %s", one_line(text), one_line(error))
            return None
        return stand_in

    def _addresses(self) -> list[str]:
        special = self._node.arguments.special
        return [f"{key}:={special[key]}" for key in ("__ip", "__hostname") if key in special]

    def _is_free(self, local: str) -> bool:
        """Return whether no node with this name is running; a killed node may have left its registration behind."""
        uri = self._graph.node_uri(local)
        if uri is None:
            return True
        api = self._graph.node_api(uri, _TIMEOUT)
        try:
            api.pid()
        except UnreachableError:
            return True
        except Error:
            return False
        finally:
            api.close()
        return False

    def close(self) -> None:
        """End all nodes. If `update` is still waiting for the master in another thread, it starts no more nodes."""
        self._is_closing = True
        for local in [*self._running]:
            self._end(local)
