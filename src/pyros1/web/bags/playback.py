"""Plays a bag in the running ROS system. Each jump to another time creates a new player."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass, replace
from time import monotonic
from typing import Any

from pyros1.bag.play.control import Control
from pyros1.bag.play.player import Player, PlayOptions, Status
from pyros1.bag.play.read_ahead import BagSet
from pyros1.ground.errors import Error
from pyros1.ground.terminal_text import untrusted
from pyros1.node import Node
from pyros1.web.bags.open_bag import OpenBag

_CONNECT_TIMEOUT = 0.3
"""Seconds to wait for subscribers to connect before the first message."""
_MIN_LOOP_SECONDS = 0.1
"""Minimum duration of a loop iteration in seconds, however short the bag is."""
_MAX_UNPLAYABLE = 20
CLOCK_RATE = 100.0
"""Messages per second on /clock."""


@dataclass(frozen=True)
class PlaybackSettings:
    """How a page plays a bag.

    Attributes:
        rate: the speed factor; 2 plays twice as fast as recorded.
        loop: whether to start again from the beginning when the end is reached.
        paused: whether playback is paused.
        clock: whether to publish /clock.
        topics: the topics to publish.
    """

    rate: float = 1.0
    loop: bool = False
    paused: bool = False
    clock: bool = False
    topics: frozenset[str] = frozenset()


class Playback:
    """Plays a bag in a thread.

    Args:
        node: the node that publishes; this class does not shut it down.
        bag: the bag, which must stay open until `close` returns.
        settings: the initial settings.
        start: where to start, in seconds since the bag's start.
        on_change: called from the thread after each change to the result of `status`.
    """

    def __init__(
        self, node: Node, bag: OpenBag, settings: PlaybackSettings, start: float, on_change: Callable[[], object]
    ) -> None:
        self._node = node
        self._bag = bag
        self._settings = settings
        self._time = start
        self._on_change = on_change
        self._lock = threading.Lock()
        self._control: Control | None = None
        self._restart_requested = False  # whether playing must restart, at self._time
        self._closed = False
        self._resume_event = threading.Event()  # wakes the thread that waits at the end of the bag
        self._state = "paused" if settings.paused else "running"
        self._problem = ""
        self._num_dropped = 0
        self._unplayable: dict[str, str] = {}
        self._thread = threading.Thread(target=self._run, name="web: playback", daemon=True)
        self._thread.start()

    def change(self, settings: PlaybackSettings, start: float | None) -> None:
        """Change the settings, and continue.

        Args:
            settings: the new settings.
            start: where to continue, in seconds since the bag's start; None for the current time.
        """
        with self._lock:
            old_settings, self._settings = self._settings, settings
            if start is not None:
                self._time = start
            if start is not None or replace(old_settings, paused=settings.paused, loop=settings.loop) != settings:
                self._restart_requested = True
                if self._control is not None:
                    self._control.end()
            elif self._control is not None:
                self._control.set_paused(settings.paused)
            if self._restart_requested or old_settings.paused != settings.paused:
                self._resume_event.set()

    def status(self) -> dict[str, Any]:
        """Return the playback's state for a page. The state's time is in seconds since the bag's start."""
        with self._lock:
            unplayable = dict(list(self._unplayable.items())[:_MAX_UNPLAYABLE])
            return {
                "state": self._state,
                "time": self._time,
                "problem": self._problem,
                "dropped": self._num_dropped,
                "unplayable": {untrusted(topic): untrusted(reason) for topic, reason in unplayable.items()},
            }

    def close(self) -> None:
        """Stop playing, and wait for the thread to end."""
        with self._lock:
            self._closed = True
            if self._control is not None:
                self._control.end()
            self._resume_event.set()
        self._thread.join()

    def _run(self) -> None:
        player: Player | None = None
        while not self._closed:
            self._resume_event.clear()
            started_at, problem = monotonic(), ""
            try:
                player = self._play(player)
            except (Error, OSError) as error:
                player, problem = None, str(error)
            except Exception as error:  # noqa: BLE001 - a bug, which the page should display
                player, problem = None, f"internal server error: {error!r:.500}"
            with self._lock:
                self._problem = problem
                if self._closed or self._restart_requested:
                    continue
                loop = self._settings.loop and not problem
                if loop:
                    self._time = 0.0
                else:
                    self._state, self._time = ("failed", self._time) if problem else ("ended", self._bag.length)
            self._on_change()
            if loop:
                self._resume_event.wait(max(0.0, _MIN_LOOP_SECONDS - (monotonic() - started_at)))
                continue
            self._resume_event.wait()  # ends on a change, or on `close`
            with self._lock:
                if not self._restart_requested and not self._closed:
                    self._time = 0.0  # resuming at the end of the bag means starting again
        if player is not None:
            player.close()

    def _play(self, previous: Player | None) -> Player:
        """Create a player and play until the bag ends, the settings change, or `close` is called; return the player.

        Args:
            previous: the player of the previous call, which is closed as soon as the new player exists.
        """
        with self._lock:
            settings, start, self._restart_requested = self._settings, self._time, False
            control = self._control = Control(settings.paused)
            if self._closed:
                control.end()
            self._state = "paused" if settings.paused else "running"
        options = PlayOptions(rate=settings.rate, start=start, clock_rate=CLOCK_RATE if settings.clock else 0.0)
        with BagSet([self._bag.bag.reader], settings.topics) as bags:
            try:
                player = Player(self._node, bags, options, control, self._on_status)
            finally:
                if previous is not None:
                    previous.close()
            try:
                with self._lock:
                    self._unplayable = player.unplayable
                player.read_ahead()
                if previous is None:
                    self._wait_for_subscribers(control)
                player.run()
            except BaseException:
                player.close()
                raise
            finally:
                with self._lock:
                    self._control = None
                control.close()
                self._num_dropped = player.dropped()
        return player

    @staticmethod
    def _wait_for_subscribers(control: Control) -> None:
        deadline = monotonic() + _CONNECT_TIMEOUT
        while not control.end_requested and (remaining := deadline - monotonic()) > 0:
            control.wait(remaining)

    def _on_status(self, status: Status) -> None:
        with self._lock:
            if not self._restart_requested:
                self._time, self._state = max(0.0, status.elapsed), status.state.lower()
        self._on_change()
