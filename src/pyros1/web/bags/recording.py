"""A recording started by a page. It continues after this page is closed, until a page stops it or the server exits."""

from __future__ import annotations

import re
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from time import monotonic
from typing import Any

from pyros1.bag.errors import BagError
from pyros1.bag.record.file_names import FileNames
from pyros1.bag.record.model import RecordOptions
from pyros1.bag.record.recorder import Events, Recorder
from pyros1.bag.record.topic_selection import TopicSelection
from pyros1.bag.record.topics import TopicSearch
from pyros1.ground import names
from pyros1.ground.errors import Error, NodeShutdownError
from pyros1.ground.terminal_text import untrusted
from pyros1.node import Node
from pyros1.web.server.wire import RequestError

COMPRESSIONS = ("none", "lz4", "bz2")
_POLL_PERIOD = 1.0
"""Seconds between checks for new topics."""
_MAX_TOPICS = 500
_PREFIX_PATTERN = re.compile(r"[\w+=-][\w.+=-]{0,99}\Z", re.ASCII)


class Recording:
    """A recording that runs in a thread.

    Args:
        node: the node that subscribes; this class does not shut it down.
        folder: the folder in which the file is created.
        prefix: the beginning of the file's name, in front of the date; may be empty.
        topics: full names of the topics; None for all topics, including those that appear later.
        compression: one of `COMPRESSIONS`.
        may_see: returns whether a topic may be recorded.

    Attributes:
        is_running: whether the recording is running.

    Raises:
        RequestError: the name or the compression is invalid, or the file cannot be created.
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
        if prefix and not _PREFIX_PATTERN.match(prefix):
            raise RequestError(
                "the name may contain only letters, digits, dots, + = - and _, and must not begin with a dot"
            )
        if compression not in COMPRESSIONS:
            raise RequestError(f"the compression must be one of {', '.join(COMPRESSIONS)}")
        self.is_running = True
        self._may_see = may_see
        self._warning = ""
        self._path = ""
        self._started_at = monotonic()
        self._duration = 0.0
        self._last_counts: dict[str, tuple[int, int]] = {}
        self._measured_at = self._started_at
        self._topic_rows: list[dict[str, Any]] = []
        self._lock = threading.Lock()
        self._stop_event = threading.Event()
        self._topic_search = TopicSearch(node, TopicSelection(topics or (), all_topics=topics is None))
        options = RecordOptions(names=_FileNamesInFolder(prefix, folder=folder), compression=compression)
        events = Events(on_opened=self._on_opened, on_warning=self._on_warning, on_ended=self._stop_event.set)
        try:
            self._recorder = Recorder(node, options, events)
        except OSError as error:
            raise RequestError(f"cannot write into {untrusted(str(folder))}: {error.strerror}") from None
        except BagError as error:
            raise RequestError(str(error)) from None
        self._thread = threading.Thread(target=self._run, name="web: recording", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Stop the recording, and wait until its file is closed."""
        self._stop_event.set()
        self._thread.join()

    def status(self) -> dict[str, Any]:
        """Return the recording's state for a page.

        Rates are averages since an earlier call that was at least a second ago; without such a call, they are null.
        """
        with self._lock:
            now = monotonic()
            elapsed = now - self._measured_at
            if elapsed >= _POLL_PERIOD or not self.is_running:
                self._measured_at, self._topic_rows = now, self._make_topic_rows(elapsed)
            elif len(self._topic_rows) < len(self._recorder.topics):
                self._topic_rows = self._make_topic_rows(0.0)
            error = self._recorder.error
            return {
                "running": self.is_running,
                "path": untrusted(self._path),
                "seconds": round(now - self._started_at if self.is_running else self._duration, 1),
                "bytes": self._recorder.size,
                "messages": sum(topic.written for topic in list(self._recorder.topics.values())),
                "topics": self._topic_rows[:_MAX_TOPICS],
                "more": max(0, len(self._topic_rows) - _MAX_TOPICS),
                "warning": self._warning,
                "error": "" if error is None else _error_text(error),
            }

    def _make_topic_rows(self, elapsed: float) -> list[dict[str, Any]]:
        rows = []
        for topic in sorted(self._recorder.topics.values(), key=lambda topic: topic.name):
            previous = self._last_counts.get(topic.name)
            if elapsed:
                self._last_counts[topic.name] = (topic.messages, topic.bytes)
            messages, size = previous or (0, 0)
            has_rate = self.is_running and elapsed and previous is not None
            rows.append(
                {
                    "name": topic.name,
                    "messages": topic.written,
                    "bytes": topic.bytes,
                    "hz": (topic.messages - messages) / elapsed if has_rate else None,
                    "rate": (topic.bytes - size) / elapsed if has_rate else None,
                    "dropped": topic.dropped,
                }
            )
        return rows

    def _run(self) -> None:
        try:
            while not self._stop_event.is_set():
                for name in self._topic_search.new_topics():
                    if names.is_legal_name(name) and self._may_see(name):
                        self._recorder.subscribe(name)
                self._stop_event.wait(_POLL_PERIOD)
        except NodeShutdownError:
            pass  # the server is exiting
        except Error as error:
            self._warning = str(error)
        for topic in list(self._recorder.topics.values()):
            if topic.subscriber is not None:
                topic.subscriber.unregister()
        self._recorder.close()
        self._duration = monotonic() - self._started_at
        self.is_running = False

    def _on_opened(self, path: str) -> None:
        self._path = path

    def _on_warning(self, message: str) -> None:
        self._warning = untrusted(message)


@dataclass(frozen=True)
class _FileNamesInFolder(FileNames):
    """Generates names of files in a given folder."""

    folder: Path = Path()

    def name(self, number: int, moment: float) -> str:
        return str(self.folder / super().name(number, moment))


def _error_text(error: Exception) -> str:
    return f"cannot write the bag: {error.strerror}" if isinstance(error, OSError) else untrusted(str(error))
