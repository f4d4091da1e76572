"""Prints the status of ``bag record`` and ``bag play`` while they run."""

from __future__ import annotations

import shutil
import sys
import threading
import time
from typing import TextIO

from pyros1.bag.record.model import Topic
from pyros1.bag.record.recorder import Recorder
from pyros1.node.log.logger import Log


class StatusLine:
    """Prints messages and, on a terminal, a status line below them that is updated in place.

    Args:
        enabled: Whether anything is printed.
        stream: The output stream; None for stdout.
        log: A log that also receives all messages, even if `enabled` is False; None for no log.
    """

    def __init__(self, enabled: bool = True, stream: TextIO | None = None, log: Log | None = None) -> None:
        self._log = log
        self._enabled = enabled
        self._stream = sys.stdout if stream is None else stream
        self._is_terminal = enabled and self._stream.isatty()
        self._is_shown = False
        self._lock = threading.Lock()

    def print_message(self, text: str) -> None:
        """Print a message in the stock tool's format (L113)."""
        if self._enabled:
            with self._lock:
                self._clear()
                self._write(f"[ INFO] [{time.time():.9f}]: {text}\n")
        if self._log is not None:
            self._log.note(text)

    def show(self, text: str) -> None:
        """Display the status line, truncated to the terminal's width. Do nothing if the output is not a terminal."""
        if self._is_terminal:
            width = shutil.get_terminal_size().columns - 1
            with self._lock:
                self._write(f"\r{text[:width]}\x1b[K")
                self._is_shown = True

    def clear(self) -> None:
        """Remove the status line."""
        with self._lock:
            self._clear()

    def _clear(self) -> None:
        if self._is_shown:
            self._write("\r\x1b[K")
            self._is_shown = False

    def _write(self, text: str) -> None:
        try:
            self._stream.write(text)
            self._stream.flush()
        except (OSError, ValueError):  # the reader has closed the pipe; the recording continues
            self._enabled = self._is_terminal = False


class RecordingStatus:
    """Describes the progress of a recording in a status line.

    Args:
        recorder: The recorder to report on.
    """

    def __init__(self, recorder: Recorder) -> None:
        self._recorder = recorder
        self._started_at = self._last_call_at = time.monotonic()
        self._last_counts: dict[str, tuple[int, int]] = {}

    def text(self) -> str:
        """Return the text: time, size, and each topic's rates since the last call, with the busiest topics first."""
        now = time.monotonic()
        elapsed, self._last_call_at = max(1e-3, now - self._last_call_at), now
        topic_rates = []
        for topic in list(self._recorder.topics.values()):
            last_messages, last_bytes = self._last_counts.get(topic.name, (0, 0))
            self._last_counts[topic.name] = (topic.messages, topic.bytes)
            topic_rates.append(
                ((topic.bytes - last_bytes) / elapsed, (topic.messages - last_messages) / elapsed, topic)
            )
        topic_rates.sort(key=lambda topic_rate: (topic_rate[2].dropped > 0, topic_rate[0]), reverse=True)
        total_bandwidth = sum(topic_rate[0] for topic_rate in topic_rates)
        totals_text = (
            f"{now - self._started_at:.0f} s  {format_size(self._recorder.size)}  {format_size(total_bandwidth)}/s"
        )
        return "  ".join([totals_text, *(_format_topic(*topic_rate) for topic_rate in topic_rates)])


def _format_topic(bandwidth: float, rate: float, topic: Topic) -> str:
    dropped_text = f" DROPPED {topic.dropped}" if topic.dropped else ""
    return f"| {topic.name} {rate:.4g} Hz {format_size(bandwidth)}/s{dropped_text}"


def recording_summary(recorder: Recorder) -> str:
    """Return a summary of a finished recording: the totals, and one line per topic."""
    topics = sorted(recorder.topics.values(), key=lambda topic: topic.name)
    width = max((len(topic.name) for topic in topics), default=0)
    lines = [
        f"  {topic.name:{width}}  {topic.written:9} messages  {format_size(topic.bytes):>9}  {topic.dropped} dropped"
        for topic in topics
    ]
    report = recorder.report
    file_count_text = f"{len(report.files)} file{'s' if len(report.files) != 1 else ''}"
    return "\n".join([f"{report.messages} messages, {format_size(report.bytes)} in {file_count_text}", *lines])


def format_size(size: float) -> str:
    """Return a number of bytes in human-readable form, such as ``1.5 MB``."""
    for unit in ("B", "KB", "MB", "GB"):
        if size < 1000:
            return f"{size:.3g} {unit}"
        size /= 1000
    return f"{size:.3g} TB"
