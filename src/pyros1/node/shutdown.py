"""The shutdown of a node, once and in order, whether the program, a signal, the master or the interpreter causes it."""

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


class Shutdown:
    """The shutdown of a node.

    Order: early hooks run, while everything works as before; every wait in the node ends; the hooks run (publishing
    still works); then everything is closed.

    In a forked process only hooks and waits, which are in its memory, end. The sockets, their epoll and the
    registrations belong to the node, which continues in the original process.

    Args:
        context: the node.
        clock: its clock, whose sleeps are ended.
        close: closes everything; called once.
    """

    def __init__(self, context: Context, clock: Clock, close: Callable[[], None]) -> None:
        self._context = context
        self._clock = clock
        self._close = close
        self._hooks: deque[Callable[[], object]] = deque()
        self._early: deque[Callable[[], object]] = deque()
        self._hooks_are_run = False
        self._first = [True]  # removed by the thread that ends the node
        self._closing_thread: int | None = None
        self._done = Event()
        self._signals = SignalHandlers(self._on_signal)
        self._pid = os.getpid()  # a forked process has copies of the sockets, but not the node

    @property
    def signalled(self) -> bool:
        """Whether a signal has requested the shutdown."""
        return self._signals.count > 0

    def watch(self, signals: bool) -> None:
        """End the node at the interpreter's exit and, if requested, on SIGINT and SIGTERM."""
        atexit.register(self._end_at_exit)
        if signals:
            self._signals.install()

    def _end_at_exit(self) -> None:
        if os.getpid() != self._pid:
            return
        try:
            self.end()
        except KeyboardInterrupt:  # a second signal: nothing here could catch it, and the process must end
            die_by_signal(signal.SIGINT)
        except SystemExit as error:
            if not self.signalled or error.code != 128 + signal.SIGTERM:
                raise  # of a hook
            die_by_signal(signal.SIGTERM)

    def on_shutdown(self, hook: Callable[[], object], early: bool = False) -> None:
        """Call ``hook`` at the end of the node, or now if that has begun; an early one before waits end."""
        if self._first and early:
            self._early.append(hook)
            return
        if self._first:
            self._hooks.append(hook)
            if not self._hooks_are_run:
                return
            try:
                self._hooks.remove(hook)
            except ValueError:
                return  # it was run with the other hooks
        hook()

    def end(self, reason: str = "") -> None:
        """End the node, or wait until another thread has done so. A signal handler may call it as well."""
        me = threading.get_ident()
        try:
            del self._first[0]
        except IndexError:
            first = False
        else:
            first = True
        if first:
            self._closing_thread = me
            try:
                self._run(reason)
            finally:
                self._done.set()
        elif not self._context.loop.in_loop() and self._closing_thread != me:
            self._done.wait(MAX_CLOSE_TIME)
        self._signals.restore()

    def _run(self, reason: str) -> None:
        self._clock.ending = True
        try:
            self._run_hooks(self._early)
        finally:  # also when a hook ends the program
            self._stop(reason)

    def _stop(self, reason: str) -> None:
        context = self._context
        context.stopping.set()
        context.warn_publish_after_shutdown &= not self.signalled  # a program cannot predict when a signal comes
        self._clock.wake()
        if context.callbacks is not None:
            context.callbacks.wake()
        if reason:
            context.log.debug("shutting down: %s", reason)
        try:
            self._run_hooks(self._hooks)
            self._hooks_are_run = True
            self._run_hooks(self._hooks)  # hooks added at the last moment
        finally:  # also when a hook ends the program
            if os.getpid() == self._pid:
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
        """End the node soon: for the loop, which must not wait for it."""
        threading.Thread(target=self.end, args=(reason,), name=f"{self._context.name}:shutdown").start()

    def _on_signal(self, number: int) -> None:
        if os.getpid() != self._pid:
            if number == signal.SIGINT and not self._first:
                return  # the program's own handler has just been called, and ends its loops
            signal.signal(number, signal.SIG_DFL)
            os.kill(os.getpid(), number)
            return
        # Not here: this thread may be in the middle of anything, and hooks and the end take time.
        self._context.loop.call_soon(self.request, f"signal {number}")
