"""A recording that a page began. It goes on without the page, until a page stops it or the server ends."""

from __future__ import annotations

import re
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from time import monotonic
from typing import Any

from pyros1.bag.errors import BagError
from pyros1.bag.record.model import RecordOptions
from pyros1.bag.record.names import FileNames, Selection
from pyros1.bag.record.recorder import Events, Recorder
from pyros1.bag.record.topics import TopicSearch
from pyros1.ground import names
from pyros1.ground.errors import Error, NodeShutdownError
from pyros1.ground.shown import foreign
from pyros1.node import Node
from pyros1.web.server.wire import RequestError

COMPRESSIONS = ("none", "lz4", "bz2")
_LOOK = 1.0
"""Seconds between two looks for new topics."""
_MOST_SHOWN = 500
_PREFIX = re.compile(r"[\w+=-][\w.+=-]{0,99}\Z", re.ASCII)


class Recording:
    """A recording.

    Args:
        node: the node that subscribes; it stays as it is.
        folder: where the file will be.
        prefix: the beginning of its name, before the date; may be empty.
        topics: full names; None: all, also those that appear later.
        compression: one of `COMPRESSIONS`.
        may_see: whether a topic may be recorded.

    Raises:
        RequestError: the name or the compression is not good, or the file cannot be made.
    """

    def __init__(
        self,
        node: Node,
        folder: Path,
        prefix: str,
        topics: Sequence[str] | None,
        compression: str,
        may_see: Callable[[str], bool],
    ) -> None:
        if prefix and not _PREFIX.match(prefix):
            raise RequestError("the name may have letters, digits, dots, + = - and _, and does not begin with a dot")
        if compression not in COMPRESSIONS:
            raise RequestError(f"the compression is one of {', '.join(COMPRESSIONS)}")
        self.running = True
        self._may_see = may_see
        self._warning = ""
        self._path = ""
        self._began = monotonic()
        self._seconds = 0.0
        self._rates: dict[str, tuple[int, int]] = {}
        self._looked = self._began
        self._shown: list[dict[str, Any]] = []
        self._lock = threading.Lock()
        self._ending = threading.Event()
        self._search = TopicSearch(node, Selection(topics or (), everything=topics is None))
        options = RecordOptions(names=_InFolder(prefix, folder=folder), compression=compression)
        events = Events(opened=self._opened, warning=self._warn, ended=self._ending.set)
        try:
            self._recorder = Recorder(node, options, events)
        except OSError as error:
            raise RequestError(f"cannot write into {foreign(str(folder))}: {error.strerror}") from None
        except BagError as error:
            raise RequestError(str(error)) from None
        self._thread = threading.Thread(target=self._run, name="web: records", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """End the recording, and wait until its file is closed."""
        self._ending.set()
        self._thread.join()

    def status(self) -> dict[str, Any]:
        """Return how it goes: with the rates since the last look, of a second at least; null until then."""
        with self._lock:
            now = monotonic()
            passed = now - self._looked
            if passed >= _LOOK or not self.running:
                self._looked, self._shown = now, self._topics(passed)
            elif len(self._shown) < len(self._recorder.topics):
                self._shown = self._topics(0.0)
            error = self._recorder.error
            return {
                "running": self.running,
                "path": foreign(self._path),
                "seconds": round(now - self._began if self.running else self._seconds, 1),
                "bytes": self._recorder.size,
                "messages": sum(topic.written for topic in list(self._recorder.topics.values())),
                "topics": self._shown[:_MOST_SHOWN],
                "more": max(0, len(self._shown) - _MOST_SHOWN),
                "warning": self._warning,
                "error": "" if error is None else _reason(error),
            }

    def _topics(self, passed: float) -> list[dict[str, Any]]:
        shown = []
        for topic in sorted(self._recorder.topics.values(), key=lambda topic: topic.name):
            before = self._rates.get(topic.name)
            if passed:
                self._rates[topic.name] = (topic.messages, topic.bytes)
            messages, size = before or (0, 0)
            live = self.running and passed and before is not None
            shown.append(
                {
                    "name": topic.name,
                    "messages": topic.written,
                    "bytes": topic.bytes,
                    "hz": (topic.messages - messages) / passed if live else None,
                    "rate": (topic.bytes - size) / passed if live else None,
                    "dropped": topic.dropped,
                }
            )
        return shown

    def _run(self) -> None:
        try:
            while not self._ending.is_set():
                for name in self._search.new_topics():
                    if names.is_legal_name(name) and self._may_see(name):
                        self._recorder.subscribe(name)
                self._ending.wait(_LOOK)
        except NodeShutdownError:
            pass  # the server ends
        except Error as error:
            self._warning = str(error)
        for topic in list(self._recorder.topics.values()):
            if topic.subscriber is not None:
                topic.subscriber.unregister()
        self._recorder.close()
        self._seconds = monotonic() - self._began
        self.running = False

    def _opened(self, path: str) -> None:
        self._path = path

    def _warn(self, text: str) -> None:
        self._warning = foreign(text)


@dataclass(frozen=True)
class _InFolder(FileNames):
    """Names of files in a folder."""

    folder: Path = Path()

    def name(self, number: int, moment: float) -> str:
        return str(self.folder / super().name(number, moment))


def _reason(error: Exception) -> str:
    return f"cannot write the bag: {error.strerror}" if isinstance(error, OSError) else foreign(str(error))
