"""Notifies nodes of changes (M38-M42).

Each node has its own queue, with one call in progress at a time, in order. Nodes do not wait for each other. A newer
notice replaces a queued one about the same subject, so a node that does not respond needs only a bounded amount of
memory, and receives the latest state when it responds again.
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
RECHECK_S: Final = 1.0
"""Seconds after which to warn about a subscriber that could not be reached, if it is still registered then."""

MAX_QUEUED: Final = 1000
"""Maximum number of notices queued for one node; the oldest are dropped."""

_Key = tuple[str, str, str]


class Notifier:
    """Sends notices to nodes, on the loop.

    Args:
        caller: makes the calls; its timeout limits how long a node that does not respond delays its other notices.
        log: ``log(level, text)``.
        warn: called with a message when a subscriber cannot be reached, once per outage. A subscriber that receives no
            notices does not connect to new publishers, and cannot find out why. Subscribers that are just closing,
            and unregister within `RECHECK_S`, cause no warning.
        is_subscribed: ``is_subscribed(node, topic, api)``, whether a node is registered as subscriber of a topic at
            this API URI.
        call_later: ``call_later(seconds, function, *args)``, which does not wait.
    """

    def __init__(
        self,
        caller: RpcCaller,
        log: Callable[[str, str], object],
        warn: Callable[[str], object] = lambda text: None,
        is_subscribed: Callable[[str, str, str], bool] = lambda node, topic, api: True,
        call_later: Callable[..., object] = lambda seconds, function, *args: function(*args),
    ) -> None:
        self._caller = caller
        self._log = log
        self._warn = warn
        self._is_subscribed = is_subscribed
        self._call_later = call_later
        self._reported_apis: set[str] = set()
        self._in_flight: dict[str, _Key] = {}  # API URI -> key of the notice being sent
        self._queued: dict[str, dict[_Key, Notice]] = {}  # API URI -> queued notices

    def send(self, notices: Sequence[Notice]) -> None:
        """Queue notices, in order; a node without a call in progress receives its notice immediately."""
        for notice in notices:
            key = _notice_key(notice)
            if notice.api not in self._in_flight:
                if not notice.is_repeat:
                    self._call(notice)
                continue
            queued = self._queued.setdefault(notice.api, {})
            if notice.is_repeat and key not in queued and key != self._in_flight[notice.api]:
                continue
            queued.pop(key, None)  # the newer notice is put at the end
            queued[key] = notice
            if len(queued) > MAX_QUEUED:
                del queued[next(iter(queued))]

    def _call(self, notice: Notice) -> None:
        if notice.method == "publisherUpdate":
            description = f"publisherUpdate[{notice.subject}] -> {notice.api} {notice.value[0]}"
        else:
            description = f"{notice.method}[{notice.subject}] -> {notice.api}"
        started_at = monotonic()

        def on_done(value: Any, error: Error | None) -> None:
            if error is None:
                self._log("info", f"{description}: sec={monotonic() - started_at:.2f}, result={value}")
                self._reported_apis.discard(notice.api)
            else:
                self._log("warn", f"{description}: sec={monotonic() - started_at:.2f}, failed: {error}")
                if notice.method == "publisherUpdate" and isinstance(error, TransportError):
                    self._on_unreachable(notice, error)
            self._send_next(notice.api)

        self._log("info", description)
        self._in_flight[notice.api] = _notice_key(notice)
        try:
            self._caller.call(notice.api, notice.method, [MASTER_NAME, notice.subject, *notice.value], on_done)
        except Error as error:
            on_done(None, error)

    def _on_unreachable(self, notice: Notice, error: TransportError) -> None:
        if notice.api in self._reported_apis:
            return
        if len(self._reported_apis) >= MAX_QUEUED:
            self._reported_apis.clear()
        self._reported_apis.add(notice.api)
        self._call_later(RECHECK_S, self._warn_unless_gone, notice, error)

    def _warn_unless_gone(self, notice: Notice, error: TransportError) -> None:
        if notice.api not in self._reported_apis:
            return  # the subscriber has been reached meanwhile
        if not self._is_subscribed(notice.node, notice.subject, notice.api):
            self._reported_apis.discard(notice.api)
            return
        try:
            host, _ = parse_uri(notice.api)
        except ProtocolError:
            return
        self._warn(
            f"{notice.node} cannot be notified of the publishers of {notice.subject}: {error}. "
            f"{connectivity_hint(host, error)}"
        )

    def _send_next(self, api_uri: str) -> None:
        queued = self._queued.get(api_uri)
        if not queued:
            self._queued.pop(api_uri, None)
            del self._in_flight[api_uri]
            return
        self._call(queued.pop(next(iter(queued))))


def _notice_key(notice: Notice) -> _Key:
    """Return the key of a notice; a newer notice replaces an older one with the same key."""
    return notice.node, notice.method, notice.subject
