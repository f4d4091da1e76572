"""Opens a bag, and shows what it contains."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from time import monotonic
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import Error
from pyros1.web.server.wire import Push, RequestError
from pyros1.web.views.view import View, string_arg

if TYPE_CHECKING:
    from pyros1.web.bags.open_bag import OpenBag
    from pyros1.web.robot import Robot

_REPORT_PERIOD = 0.2
"""Seconds between progress reports."""


class _ViewClosedError(Error):
    """The view was closed while the bag was being opened."""


class BagFileView(View):
    """The description of a bag's contents. The bag stays open while this or another view of it exists.

    Args (sent by the page):
        path: path of the bag.

    Pushes ``{"reading": bytes, "size": bytes}`` while a bag without an index is scanned, and then ``{"problem":
    TEXT}``, or the result of `pyros1.web.bags.open_bag.OpenBag.describe`.
    """

    def __init__(self, robot: Robot, args: Mapping[str, Any], wake: Callable[[], object]) -> None:
        super().__init__(robot, args, wake)
        self._path = string_arg(args, "path")
        self._size = robot.bags.bag_folders.find_file(self._path).stat().st_size
        self._bag: OpenBag | None = None
        self._pending_push: dict[str, Any] | None = None
        self._reported_at = monotonic()
        self._closed = False
        self._lock = threading.Lock()
        threading.Thread(target=self._open, name="web: open bag", daemon=True).start()

    def poll(self) -> Push | None:
        with self._lock:
            pending_push, self._pending_push = self._pending_push, None
        return None if pending_push is None else Push(pending_push)

    def close(self) -> None:
        with self._lock:
            self._closed = True
            bag, self._bag = self._bag, None
        if bag is not None:
            self.robot.bags.release(bag)

    def _open(self) -> None:
        try:
            bag = self.robot.bags.open(self._path, self._progress)
        except _ViewClosedError:
            return
        except Error as error:
            self._report({"problem": str(error)})
            return
        with self._lock:
            is_closed = self._closed
            self._bag = None if is_closed else bag
        if is_closed:
            self.robot.bags.release(bag)
            return
        try:
            self._report(bag.describe())
        except (Error, OSError, ValueError) as error:  # ValueError: the bag was closed meanwhile
            self._report({"problem": str(error)})

    def _progress(self, bytes_read: int) -> None:
        if self._closed:
            raise _ViewClosedError
        if monotonic() - self._reported_at > _REPORT_PERIOD:
            self._reported_at = monotonic()
            self._report({"reading": bytes_read, "size": self._size})

    def _report(self, data: dict[str, Any]) -> None:
        with self._lock:
            self._pending_push = data
        self.wake()


class BagView(View):
    """Base class of the views of an open bag.

    Args (sent by the page):
        path: path of a bag that a `BagFileView` has opened.
    """

    def __init__(self, robot: Robot, args: Mapping[str, Any], wake: Callable[[], object]) -> None:
        super().__init__(robot, args, wake)
        self.path = string_arg(args, "path")
        self.bag = robot.bags.borrow(self.path)
        try:
            self.change(args)
        except BaseException:
            robot.bags.release(self.bag)
            raise

    def close(self) -> None:
        self.robot.bags.release(self.bag)


def topics_arg(args: Mapping[str, Any], max_topics: int) -> list[str]:
    """Return the argument ``topics``, a list of topics' names.

    Raises:
        RequestError: the argument is not a list of strings, or is too long.
    """
    topics = args.get("topics", [])
    if not isinstance(topics, list) or len(topics) > max_topics or not all(isinstance(name, str) for name in topics):
        raise RequestError(f"topics must be a list of at most {max_topics} names")
    return topics
