"""Connects a bond to its topic (https://wiki.ros.org/bond)."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import suppress
from math import inf
from time import monotonic
from typing import Any
from uuid import uuid4

from pyros1.ground.errors import NodeShutdownError
from pyros1.msgs.bond.msg import Constants, Status
from pyros1.node import Node
from pyros1.robot_nodes.shared.bond import CONNECT_TIMEOUT, HEARTBEAT_TIMEOUT, Bond, State

_QUEUE_SIZE = 30
_MAX_WAIT = 3600.0
_END_TIMEOUT = 0.5


class BondLink:
    """Keeps a bond, in real time, until it breaks or is closed. The owner closes it when the node shuts down.

    Args:
        node: the node.
        topic: the bond's topic.
        id: the bond's name, the same on both sides.
        formed: called when the other side has appeared.
        broken: called when the bond has broken or could not be formed, but not after `close`.
        connect_timeout: how many seconds the other side may take to appear.

    Raises:
        Error: the topic's name is not valid.
    """

    def __init__(
        self,
        node: Node,
        topic: str,
        id: str,
        formed: Callable[[], object],
        broken: Callable[[], object],
        connect_timeout: float = CONNECT_TIMEOUT,
    ) -> None:
        self._node = node
        self._formed, self._broken = formed, broken
        watches = node.params.get(Constants.DISABLE_HEARTBEAT_TIMEOUT_PARAM, False) is not True
        timeout = HEARTBEAT_TIMEOUT if watches else inf
        self._bond = Bond(id, uuid4().hex, monotonic(), connect_timeout, timeout)
        self._changed = threading.Condition()  # guards the bond
        self._is_closed = False
        self._publisher = node.advertise(topic, Status, queue_size=_QUEUE_SIZE)
        self._subscriber = node.subscribe(topic, Status, self._receive, queue_size=_QUEUE_SIZE)
        self._thread = threading.Thread(target=self._run, name=f"{node.name}:bond", daemon=True)
        self._thread.start()

    def end(self) -> None:
        """End the bond, and tell the other side, without waiting for it."""
        with self._changed:
            if not self._is_closed:
                self._is_closed = True
                self._bond.end(monotonic())
                self._changed.notify()

    def close(self) -> None:
        """End the bond, tell the other side, and wait briefly for its confirmation."""
        self.end()
        if self._thread is not threading.current_thread():
            self._thread.join(_END_TIMEOUT)

    def _receive(self, status: Any) -> None:
        with self._changed:
            self._bond.receive(status, monotonic())
            self._changed.notify()

    def _run(self) -> None:
        with suppress(NodeShutdownError):
            self._keep()
            self._subscriber.unregister()
            self._publisher.unregister()

    def _keep(self) -> None:
        was = State.WAITING
        while was is not State.BROKEN:
            with self._changed:
                status, state, is_closed = self._bond.tick(monotonic()), self._bond.state, self._is_closed
            if status is not None:
                status.header.stamp = self._node.now()
                self._publisher.publish(status)
            if state is was:
                with self._changed:
                    if self._bond.state is was:
                        self._changed.wait(min(max(self._bond.next_time - monotonic(), 0.0), _MAX_WAIT))
                continue
            if state is State.ALIVE and not is_closed:
                self._formed()
            elif state is State.BROKEN and not is_closed:
                self._broken()
            was = state
