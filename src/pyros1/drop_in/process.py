"""The process's default node, which rospy and its siblings share.

Stock rospy has one node per process: programs make publishers before there is a node, and the node registers them when
it starts. This is the only mutable state at module level in pyros1.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pyros1.node import Node


class Process:
    """The default node, and what waits for it.

    Attributes:
        node: the node, once it has started; it stays after its end.
        arguments: what it was started with, so that the same call again does nothing.
    """

    def __init__(self) -> None:
        self.node: Node | None = None
        self.arguments: tuple[Any, ...] | None = None
        self._waiting: list[Callable[[Node], object]] = []
        self._hooks: list[Callable[[], object]] = []
        self._lock = threading.RLock()

    def start(self, make: Callable[[], Node], arguments: tuple[Any, ...]) -> Node:
        """Start the node, and all that waits for it, in the order of its coming."""
        with self._lock:
            self.node = node = make()
            self.arguments = arguments
            waiting, self._waiting = self._waiting, []
            hooks, self._hooks = self._hooks, []
        for hook in hooks:
            node.on_shutdown(hook)
        for begin in waiting:
            begin(node)
        return node

    def when_started(self, begin: Callable[[Node], object]) -> None:
        """Call a function with the node: now, or when it starts."""
        with self._lock:
            node = self.node
            if node is None:
                self._waiting.append(begin)
                return
        begin(node)

    def forget(self, begin: Callable[[Node], object]) -> None:
        """Do not call a function that waits for the node."""
        with self._lock:
            if begin in self._waiting:
                self._waiting.remove(begin)

    def on_shutdown(self, hook: Callable[[], object]) -> None:
        """Call a function when the node ends; at once, if it has ended."""
        with self._lock:
            node = self.node
            if node is None:
                self._hooks.append(hook)
                return
        if node.ok():
            node.on_shutdown(hook)
        else:
            hook()

    @property
    def is_shutdown(self) -> bool:
        """Whether the node has ended, or begun to end."""
        return self.node is not None and not self.node.ok()


PROCESS = Process()
