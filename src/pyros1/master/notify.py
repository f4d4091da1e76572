"""Notifies nodes of changes (M38-M42).

Each node has its own queue: one call in flight, in order. Nodes do not wait for each other, and a call starts at once
when its node is free. A newer notice about the same thing takes the place of one that still waits, so a node that does
not answer costs a bounded amount of memory, and hears the latest state first when it comes back.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from time import monotonic
from typing import Any, Final

from pyros1.ground.errors import Error, ProtocolError, TransportError
from pyros1.master.registry import Notice
from pyros1.net.connectivity import connectivity_hint
from pyros1.net.hosts import parse_uri
from pyros1.net.rpc_caller import RpcCaller

MASTER_NAME: Final = "/master"
MAX_WAITING: Final = 1000
"""Notices that may wait for one node; the oldest are dropped."""

_Key = tuple[str, str, str]


class Notifier:
    """Sender of notices, on the loop.

    Args:
        caller: makes the calls; its timeout is how long a silent node keeps its own later notices waiting.
        log: ``log(level, text)``.
        warn: gets a text about a subscriber that cannot be reached, once until it is reached: it is not told
            of new publishers and gets no messages from them, and no side can know why.
    """

    def __init__(
        self,
        caller: RpcCaller,
        log: Callable[[str, str], object],
        warn: Callable[[str], object] = lambda text: None,
    ) -> None:
        self._caller = caller
        self._log = log
        self._warn = warn
        self._reported: set[str] = set()
        self._in_flight: dict[str, _Key] = {}  # API URI -> notice being sent to it
        self._waiting: dict[str, dict[_Key, Notice]] = {}  # API URI -> notice to be sent after that

    def send(self, notices: Sequence[Notice]) -> None:
        """Queue notices, in order."""
        for notice in notices:
            key = _key(notice)
            if notice.api not in self._in_flight:
                if not notice.is_repeat:
                    self._call(notice)
                continue
            waiting = self._waiting.setdefault(notice.api, {})
            if notice.is_repeat and key not in waiting and key != self._in_flight[notice.api]:
                continue
            waiting.pop(key, None)  # the newer one goes to the end
            waiting[key] = notice
            if len(waiting) > MAX_WAITING:
                del waiting[next(iter(waiting))]

    def _call(self, notice: Notice) -> None:
        if notice.method == "publisherUpdate":
            what = f"publisherUpdate[{notice.subject}] -> {notice.api} {notice.value[0]}"
        else:
            what = f"{notice.method}[{notice.subject}] -> {notice.api}"
        began = monotonic()

        def done(value: Any, error: Error | None) -> None:
            if error is None:
                self._log("info", f"{what}: sec={monotonic() - began:.2f}, result={value}")
                self._reported.discard(notice.api)
            else:
                self._log("warn", f"{what}: sec={monotonic() - began:.2f}, failed: {error}")
                if notice.method == "publisherUpdate" and isinstance(error, TransportError):
                    self._on_unreachable(notice, error)
            self._next(notice.api)

        self._log("info", what)
        self._in_flight[notice.api] = _key(notice)
        try:
            self._caller.call(notice.api, notice.method, [MASTER_NAME, notice.subject, *notice.value], done)
        except Error as error:
            done(None, error)

    def _on_unreachable(self, notice: Notice, error: TransportError) -> None:
        if notice.api in self._reported:
            return
        if len(self._reported) >= MAX_WAITING:
            self._reported.clear()
        self._reported.add(notice.api)
        try:
            host, _ = parse_uri(notice.api)
        except ProtocolError:
            return
        self._warn(
            f"{notice.node} cannot be notified of the publishers of {notice.subject}: {error}. "
            f"{connectivity_hint(host, error)}"
        )

    def _next(self, api: str) -> None:
        waiting = self._waiting.get(api)
        if not waiting:
            self._waiting.pop(api, None)
            del self._in_flight[api]
            return
        self._call(waiting.pop(next(iter(waiting))))


def _key(notice: Notice) -> _Key:
    """Subject of a notice: a newer one with the same key replaces an older one."""
    return notice.node, notice.method, notice.subject
