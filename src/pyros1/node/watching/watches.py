"""All watches of a node; they share calls to the master, and those with the same period poll together."""

from __future__ import annotations

import os
from collections.abc import Callable
from time import monotonic
from typing import TYPE_CHECKING

from pyros1.net.rpc_caller import RpcCaller
from pyros1.node import checks
from pyros1.node.watching.lookups import Lookups

if TYPE_CHECKING:
    from pyros1.node.context import Context
    from pyros1.node.watching.liveness import Sighting
    from pyros1.node.watching.notifiers import Notifiers
    from pyros1.node.watching.watch import Watch

    Callback = Callable[[Sighting], object]

_WATCH_CALL = "watch(name, on_lost, on_found)"
_MAX_PERIOD = 3600.0


class Watches:
    """All watches of a node. Those with the same period poll together, to share one call to the master.

    Args:
        context: the node's context.
        master_uri: the master's URI.
        notifiers: create the notifiers that call the program's functions.
    """

    def __init__(self, context: Context, master_uri: str, notifiers: Notifiers) -> None:
        self._context = context
        self._notifiers = notifiers
        self._rpc = RpcCaller(context.loop, on_disconnect=self._on_disconnected)
        self._lookups = Lookups(context.loop, self._rpc, context.name, master_uri)
        self._watches_by_period: dict[float, tuple[Watch, ...]] = {}  # used only on the loop
        self._phase = int.from_bytes(os.urandom(4), "big") * 1e-6  # in seconds, so that nodes poll at different times
        self._closed = False

    def start(
        self, name: str, on_lost: Callback | None, on_found: Callback | None, period: float, limit: float
    ) -> Watch:
        """Watch a node and return the watch; see ``Node.watch``."""
        for function, label in ((on_lost, "on_lost"), (on_found, "on_found")):
            if function is not None:
                checks.check_callback(function, _WATCH_CALL, label)
        notifier = self._notifiers.make(f"watch of {name}")

        def notify(sighting: Sighting) -> None:
            function = on_found if sighting.alive else on_lost
            if function is not None:
                notifier.notify(function, sighting)

        try:
            return self.begin(name, period, limit, notify, lambda: self._notifiers.end(notifier))
        except BaseException:
            self._notifiers.end(notifier)
            raise

    def begin(
        self, name: str, period: float, limit: float, notify: Callback, on_close: Callable[[], object] = lambda: None
    ) -> Watch:
        """Watch a node, with callbacks on the loop; return the watch.

        Args:
            name: the node's full name.
            period: seconds between requests.
            limit: maximum response time in seconds.
            notify: called with each `Sighting`, on the loop.
            on_close: called when the watch is closed.

        Raises:
            TypeError, ValueError: ``period`` or ``limit`` is invalid.
            NodeError: the process was forked.
            NodeShutdownError: the node is shutting down.
        """
        from pyros1.node.watching.watch import Watch  # noqa: PLC0415 - few nodes watch others

        checks.check_positive(period, "watch: period", "s", _MAX_PERIOD)
        checks.check_positive(limit, "watch: limit", "s", _MAX_PERIOD)
        context = self._context
        context.check_process()

        def on_watch_closed(watch: Watch) -> None:
            on_close()
            context.loop.call_soon(self._forget, watch)

        watch = Watch(
            context.loop,
            self._rpc,
            self._lookups,
            context.name,
            name,
            float(period),
            float(limit),
            notify,
            on_watch_closed,
        )
        context.loop.call_soon(self._begin, watch)
        return watch

    def close(self) -> None:
        """Close all watches."""
        self._context.loop.run(self._close)
        self._rpc.close()

    # On the loop ------------------------------------------------------------------------------------------------------

    def _close(self) -> None:
        self._closed = True
        for watch in [watch for watches in self._watches_by_period.values() for watch in watches]:
            watch.close()  # before the requests are aborted, which would be reported as a loss

    def _begin(self, watch: Watch) -> None:
        if self._closed:
            watch.close()
            return
        if watch.period not in self._watches_by_period:
            self._schedule_poll(watch.period)
        self._watches_by_period[watch.period] = (*self._watches_by_period.get(watch.period, ()), watch)
        watch.poll()

    def _schedule_poll(self, period: float) -> None:
        # Poll at fixed times, which avoids drift. The times differ between nodes, so that not all of them poll at once.
        self._context.loop.call_later(period - (monotonic() + self._phase) % period, self._poll, period)

    def _poll(self, period: float) -> None:
        if self._closed or not self._watches_by_period.get(period):
            self._watches_by_period.pop(period, None)
            return
        self._schedule_poll(period)
        for watch in self._watches_by_period[period]:
            watch.poll()

    def _on_disconnected(self, uri: str) -> None:
        for watches in list(self._watches_by_period.values()):
            for watch in watches:
                watch.on_disconnected(uri)

    def _forget(self, watch: Watch) -> None:
        if watch.period in self._watches_by_period:  # `_poll` removes the entry if no watch remains
            self._watches_by_period[watch.period] = tuple(
                other for other in self._watches_by_period[watch.period] if other is not watch
            )
