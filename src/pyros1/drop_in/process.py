"""The default node of the process, shared by rospy and related modules.

Stock rospy has one node per process. A program can create publishers before it starts the node; starting it registers
them. `PROCESS` is the only mutable module-level state in pyros1.
"""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pyros1.node import Node

Hook = Callable[[str], object]


class Process:
    """The default node, and the callbacks that are waiting for it.

    Attributes:
        node: the node; None until it has been started. It is kept after its shutdown.
        arguments: the arguments with which the node was started, so that repeating the same call has no effect.
        is_starting: whether the node is being started.
        has_wall_clock: whether a clock is available without a node.
        shutdown_requested: whether shutdown was requested.
        is_shutdown: whether the node has shut down; already true while the "after" hooks run, when all waits have been
            interrupted.
        start_lock: held while the node is started, so that threads cannot start two nodes.
    """

    def __init__(self) -> None:
        self.node: Node | None = None
        self.arguments: tuple[Any, ...] | None = None
        self.is_starting = False
        self.has_wall_clock = False
        self.shutdown_requested = False
        self.is_shutdown = False
        self._reason = ""
        self._pid = 0
        self._start_callbacks: list[Callable[[Node], object]] = []
        self._hooks: dict[str, list[Hook]] = {"client": [], "before": [], "after": []}
        self._finished_phases: set[str] = set()
        self._lock = threading.RLock()
        self._shutdown_permit = [True]  # the thread that removes the item shuts down the node
        self.start_lock = threading.RLock()

    # Start ------------------------------------------------------------------------------------------------------------

    def start(self, make_node: Callable[[], Node], arguments: tuple[Any, ...]) -> Node:
        """Start the node, call the functions added with `add_start_callback` in order, and return the node."""
        self.is_starting = True
        try:
            node = make_node()
        finally:
            self.is_starting = False
        with self._lock:
            self.node = node
            self._pid = os.getpid()
            self.arguments = arguments
            callbacks, self._start_callbacks = self._start_callbacks, []
        node.on_shutdown(self._on_node_shutdown, early=True)
        node.on_shutdown(self._run_last_hooks)
        for callback in callbacks:
            callback(node)
        return node

    @property
    def is_forked(self) -> bool:
        """Whether this process was forked from the node's process, so that the node's threads do not run in it."""
        return self.node is not None and os.getpid() != self._pid

    def add_start_callback(self, callback: Callable[[Node], object]) -> None:
        """Call a function with the node: immediately, or as soon as the node is started."""
        with self._lock:
            node = self.node
            if node is None:
                self._start_callbacks.append(callback)
                return
        callback(node)

    def remove_start_callback(self, callback: Callable[[Node], object]) -> None:
        """Undo `add_start_callback`, if the function has not been called yet."""
        with self._lock:
            if callback in self._start_callbacks:
                self._start_callbacks.remove(callback)

    # Shutdown ---------------------------------------------------------------------------------------------------------

    def on_shutdown(self, hook: Hook, when: str = "client") -> None:
        """Call a function with the reason when the node shuts down, or immediately if it has already shut down.

        A hook added by another hook is called after the hooks that are already waiting.

        Args:
            hook: the function.
            when: "client" to call it first, while everything works as before; "before" to call it after all "client"
                hooks; "after" to call it when waits have been interrupted and `is_shutdown` is true.
        """
        with self._lock:
            if when not in self._finished_phases:
                self._hooks[when].append(hook)
                return
        hook("already shutdown")

    def shutdown(self, reason: str) -> None:
        """Shut down the node; without a node, only run the hooks.

        Returns immediately if another thread is shutting down the node: its hooks may be waiting for this thread.
        """
        if not self.shutdown_requested:
            self._reason = reason
        if self.node is None:
            if not self.shutdown_requested:
                self._run_first_hooks()
                self._run_last_hooks()
            return
        try:
            del self._shutdown_permit[0]
        except IndexError:
            return
        self.node.shutdown(reason)

    def _on_node_shutdown(self) -> None:
        self._shutdown_permit.clear()
        self._run_first_hooks()

    def _run_first_hooks(self) -> None:
        with self._lock:
            self.shutdown_requested = True
        self._run_hooks("client")
        self._run_hooks("before")

    def _run_last_hooks(self) -> None:
        with self._lock:
            self.is_shutdown = True
            self._finished_phases.add("after")
        self._run_hooks("after")

    def _run_hooks(self, phase: str) -> None:
        hooks = self._hooks[phase]
        while True:
            with self._lock:
                if not hooks:
                    self._finished_phases.add(phase)
                    return
                hook = hooks.pop(0)
            try:
                hook(self._reason)
            except Exception:  # noqa: BLE001 - raised by user code: the other hooks must be called as well
                import traceback  # noqa: PLC0415  importing it takes as long as importing a large part of rospy

                traceback.print_exc(file=sys.stderr)


PROCESS = Process()
