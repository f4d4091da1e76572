"""Plays a bag in the running ROS system while a page displays the playback."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from pyros1.web.bags.open_bag import MAX_TOPICS
from pyros1.web.bags.playback import Playback, PlaybackSettings
from pyros1.web.server.wire import Push, RequestError
from pyros1.web.views.bag.file import BagView, topics_arg
from pyros1.web.views.view import number_arg

if TYPE_CHECKING:
    from pyros1.web.robot import Robot

MIN_SPEED, MAX_SPEED = 0.01, 100.0
_MAX_SECONDS = 4.29e9  # the sum of two such times in nanoseconds fits in 64 bits


class BagPlayView(BagView):
    """The playback of a bag, which ends when this view is closed.

    Args (sent by the page):
        path: path of an open bag.
        rate: the speed factor; 2 plays twice as fast as recorded.
        loop, paused, clock: see `pyros1.web.bags.playback.PlaybackSettings`.
        topics: names of the topics to publish; all topics if absent.
        start: where to start, or to continue after a change, in seconds since the bag's start. If absent, playback
            continues from its current position.

    Pushes the result of `pyros1.web.bags.playback.Playback.status`.
    """

    period = 1 / 15

    def __init__(self, robot: Robot, args: Mapping[str, Any], wake: Callable[[], object]) -> None:
        if robot.access.read_only:
            raise RequestError("this server is read-only (--read-only)")
        self._node = robot.node
        self._playback: Playback | None = None
        self._last_status: dict[str, Any] = {}
        super().__init__(robot, args, wake)

    def change(self, args: Mapping[str, Any]) -> None:
        if args.get("clock") is True:
            self.robot.check_visible("/clock")
        selected = topics_arg(args, MAX_TOPICS) if args.get("topics") is not None else list(self.bag.topics)
        settings = PlaybackSettings(
            rate=number_arg(args, "rate", MIN_SPEED, MAX_SPEED, 1.0),
            loop=args.get("loop") is True,
            paused=args.get("paused") is True,
            clock=args.get("clock") is True,
            topics=frozenset(self.bag.recorded_names(selected)),
        )
        start = None if args.get("start") is None else number_arg(args, "start", -_MAX_SECONDS, _MAX_SECONDS, 0.0)
        if start is not None:
            start = min(max(0.0, start), self.bag.length)
        if self._playback is None:
            self._playback = Playback(self._node, self.bag, settings, start or 0.0, self.wake)
        else:
            self._playback.change(settings, start)

    def poll(self) -> Push | None:
        status = self._playback.status() if self._playback is not None else {}
        if status == self._last_status:
            return None
        self._last_status = status
        return Push(status)

    def close(self) -> None:
        if self._playback is not None:
            self._playback.close()
        super().close()
