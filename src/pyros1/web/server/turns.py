"""Decides who sends to a client: the thread in which a message has just arrived, or the event loop (no I/O)."""

from __future__ import annotations

from enum import Enum, auto


class _Holder(Enum):
    """The holder of the turn to send.

    ::

        LOOP    the loop has sent everything             -> NOBODY
        NOBODY  a thread starts to send                  -> THREAD
        NOBODY  something is queued                      -> LOOP, which is woken
        THREAD  the thread has sent; nothing is queued   -> NOBODY
        THREAD  the thread has sent; something is queued -> LOOP, which is woken
    """

    LOOP = auto()  # the loop sends what is queued
    NOBODY = auto()  # nothing is queued, and nothing is being sent
    THREAD = auto()  # a thread sends one message, which bypasses the queue


class Turns:
    """Keeps track of whose turn it is to send: a thread's, the event loop's, or nobody's.

    Only the loop or one thread sends at a time, and threads send only when nothing is queued, so messages keep their
    order. Not thread-safe: the object belongs to a queue, and is used while the queue's lock is held.
    """

    def __init__(self) -> None:
        self._holder = _Holder.LOOP
        self._has_left_something = False

    @property
    def is_free(self) -> bool:
        """Whether a thread may start to send."""
        return self._holder is _Holder.NOBODY

    @property
    def is_threads(self) -> bool:
        """Whether a thread is sending, so that the loop must wait until it is woken."""
        return self._holder is _Holder.THREAD

    def begin(self) -> bool:
        """Let a thread send if nobody else does; return whether it may. It must then call `end`."""
        if self._holder is not _Holder.NOBODY:
            return False
        self._holder = _Holder.THREAD
        return True

    def end(self) -> bool:
        """End a thread's turn; return whether the loop must be woken."""
        left, self._has_left_something = self._has_left_something, False
        self._holder = _Holder.LOOP if left else _Holder.NOBODY
        return left

    def leave_to_loop(self) -> bool:
        """Record that something was queued; return whether the loop must be woken now. If a thread is sending, it need
        not: `end` then returns True.
        """
        if self._holder is _Holder.THREAD:
            self._has_left_something = True
            return False
        self._holder = _Holder.LOOP
        return True

    def release(self) -> None:
        """End the loop's turn: nothing is queued, and everything has been sent."""
        if self._holder is _Holder.LOOP:
            self._holder = _Holder.NOBODY
