"""Shuts down a node once and in order, whatever the cause: the program, a signal, the master or the interpreter's
exit."""

from __future__ import annotations

import atexit
import os
import signal
import threading
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING

from pyros1.ground.interrupts import die_by_signal
from pyros1.net.signal_safe import Event
from pyros1.node.signals import SignalHandlers

if TYPE_CHECKING:
    from pyros1.node.clock import Clock
    from pyros1.node.context import Context

MAX_CLOSE_TIME = 15.0
"""Maximum number of seconds that `Shutdown.end` waits for another thread to shut down the node."""


class Shutdown:
    """The shutdown of a node.

    The order is: the early hooks run, while everything works as before; every wait in the node is interrupted; the
    other hooks run, while publishing still works; and everything is closed.

    In a forked process, the hooks run and waits are interrupted, but nothing is closed: the sockets, the epoll instance
    that watches them and the registrations belong to the node, which continues in the parent process.

    Args:
        context: the node's context.
        clock: the node's clock, whose sleeps are interrupted.
        close: closes everything; called once.
    """

    def __init__(self, context: Context, clock: Clock, close: Callable[[], None]) -> None:
        self._context = context
        self._clock = clock
        self._close = close
        self._hooks: deque[Callable[[], object]] = deque()
        self._early_hooks: deque[Callable[[], object]] = deque()
        self._hooks_have_run = False
        self._not_started = [True]  # the item is removed by the thread that shuts down the node
        self._closing_thread: int | None = None
        self._done = Event()
        self._signals = SignalHandlers(self._on_signal)
        self._node_pid = os.getpid()  # to detect a forked process, which has copies of the sockets, but not the node

    @property
    def signalled(self) -> bool:
        """Whether a signal has requested the shutdown."""
        return self._signals.count > 0

    def watch(self, handle_signals: bool) -> None:
        """From now on, shut down the node when the interpreter exits and, if requested, on SIGINT and SIGTERM."""
        atexit.register(self._end_at_exit)
        if handle_signals:
            self._signals.install()

    def _end_at_exit(self) -> None:
        if os.getpid() != self._node_pid:
            return
        try:
            self.end()
        except KeyboardInterrupt:  # a second signal: nobody could catch the exception, and the process must exit
            die_by_signal(signal.SIGINT)
        except SystemExit as error:
            if not self.signalled or error.code != 128 + signal.SIGTERM:
                raise  # raised by a hook
            die_by_signal(signal.SIGTERM)

    def on_shutdown(self, hook: Callable[[], object], early: bool = False) -> None:
        """Call ``hook`` when the node shuts down, or immediately if the shutdown has already started.

        Args:
            hook: the function to call.
            early: whether to call it before the hooks that are not early.
        """
        if self._not_started and early:
            self._early_hooks.append(hook)
            return
        if self._not_started:
            self._hooks.append(hook)
            if not self._hooks_have_run:
                return
            try:
                self._hooks.remove(hook)
            except ValueError:
                return  # the thread that shuts down the node has called the hook
        hook()

    def end(self, reason: str = "") -> None:
        """Shut down the node, or wait until another thread has done so. Allowed in signal handlers."""
        thread_id = threading.get_ident()
        try:
            del self._not_started[0]
        except IndexError:
            is_first = False
        else:
            is_first = True
        if is_first:
            self._closing_thread = thread_id
            try:
                self._run(reason)
            finally:
                self._done.set()
        elif not self._context.loop.in_loop() and self._closing_thread != thread_id:
            self._done.wait(MAX_CLOSE_TIME)
        self._signals.restore()

    def _run(self, reason: str) -> None:
        self._clock.ending = True
        try:
            self._run_hooks(self._early_hooks)
        finally:  # even if a hook exits the program
            self._stop(reason)

    def _stop(self, reason: str) -> None:
        context = self._context
        context.stopping.set()
        context.warn_publish_after_shutdown &= not self.signalled  # a program cannot foresee a signal
        self._clock.wake()
        if context.callback_queue is not None:
            context.callback_queue.wake()
        if reason:
            context.log.debug("shutting down: %s", reason)
        try:
            self._run_hooks(self._hooks)
            self._hooks_have_run = True
            self._run_hooks(self._hooks)  # hooks added while the others ran
        finally:  # even if a hook exits the program
            if os.getpid() == self._node_pid:
                self._close()
            atexit.unregister(self._end_at_exit)

    def _run_hooks(self, hooks: deque[Callable[[], object]]) -> None:
        while hooks:
            hook = hooks.popleft()
            try:
                hook()
            except Exception as error:
                self._context.log.exception(f"bad shutdown hook {hook!r}", error=error)

    def request(self, reason: str) -> None:
        """Shut down the node in another thread, and return immediately; for calls on the loop, which must not wait."""
        threading.Thread(target=self.end, args=(reason,), name=f"{self._context.name}:shutdown").start()

    def _on_signal(self, number: int) -> None:
        if os.getpid() != self._node_pid:
            if number == signal.SIGINT and not self._not_started:
                return  # the program's own handler has just been called, and will stop its loops
            signal.signal(number, signal.SIG_DFL)
            os.kill(os.getpid(), number)
            return
        # The shutdown runs hooks and takes time, so it must not run in a signal handler, which may have interrupted
        # anything.
        self._context.loop.call_soon(self.request, f"signal {number}")
