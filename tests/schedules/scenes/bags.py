"""The bag recorder: messages of several topics come in threads while one thread writes, splits, runs out of disk, ends.

Every message that was taken is in the files, in order, or counted as dropped or as too late; every file that was begun
is closed; and the counts say so as soon as the recording has ended.
"""

from __future__ import annotations

import errno
import os
import tempfile
from collections.abc import Callable
from io import FileIO
from pathlib import Path
from typing import Any

from pyros1.bag.format.reader import BagReader
from pyros1.bag.format.writer import EMPTY_BAG_SIZE
from pyros1.bag.record.file_names import FileNames
from pyros1.bag.record.model import RecordOptions
from pyros1.bag.record.queue import MESSAGE_OVERHEAD
from pyros1.bag.record.recorder import Events, Recorder
from pyros1.bag.record.snapshot import SnapshotBuffer
from pyros1.msgs import AnyMsg

from ..stage import Scenario, Stage

TOPICS, MESSAGES = ("/a", "/b"), 6
SIZE = 200
"""Bytes of a message, which begin with its number."""


class Source:
    """What recordings need of a node; its topics get their messages from the scene."""

    def __init__(self) -> None:
        self.params: dict[str, Any] = {}
        self.topics: dict[str, Callable[[Any], object]] = {}

    def subscribe(self, name: str, _type: Any, callback: Callable[[Any], object], **_options: object) -> Source:
        """Let a topic be recorded."""
        self.topics[name] = callback
        return self

    def unregister(self) -> None:
        """Do nothing: messages that are under way may come."""

    def publish(self, stage: Stage, name: str) -> Callable[[], None]:
        """Return a function that lets all messages of a topic come, one after the other."""

        def come() -> None:
            for number in range(MESSAGES):
                message: Any = AnyMsg(number.to_bytes(4, "little") + bytes(SIZE - 4))
                message._connection_header = {"callerid": "/talker", "type": "a/B", "md5sum": "0" * 32}
                self.topics[name](message)
                stage.time.sleep(20e-6)

        return come


class Recording(Scenario):
    """Two topics, whose recording ends when all has come.

    Attributes:
        settings: options of the recording.
        enough: messages after which it is ended; more may come meanwhile.
        loses: whether messages may be dropped.
    """

    modules = tuple(f"pyros1.bag.record.{name}" for name in ("recorder", "queue", "file", "model"))
    limits: tuple[tuple[str, str, Any], ...] = (
        ("pyros1.bag.record.recorder", "_POLL_PERIOD", 100e-6),
        ("pyros1.bag.record.file", "FLUSH_INTERVAL", 150e-6),
    )
    settings: dict[str, Any] = {}
    enough = len(TOPICS) * MESSAGES
    loses = False

    def play(self, stage: Stage) -> None:
        """Play it."""
        with tempfile.TemporaryDirectory() as folder:
            self.act(stage, Path(folder))
            assert not [path for path in Path(folder).iterdir() if path.suffix != ".bag"], "a file was not closed"

    def act(self, stage: Stage, folder: Path) -> None:
        """Play it, with files there."""
        source: Any = Source()
        ended: list[bool] = []
        names = FileNames(str(folder / "r"), has_date=False, has_number=bool(self.settings.get("split")))
        options = RecordOptions(names=names, min_space=0, **self.settings)
        recorder = Recorder(source, options, Events(on_ended=lambda: ended.append(True)))
        for name in TOPICS:
            recorder.subscribe(name)

        def end() -> None:
            topics = recorder.topics.values()
            stage.until(lambda: ended or sum(topic.messages for topic in topics) >= self.enough or self.left(recorder))
            recorder.close()
            written = sum(topic.written for topic in topics)
            assert written == recorder.report.messages, f"{written} counted, {recorder.report.messages} in the files"

        stage.together(end, *(source.publish(stage, name) for name in TOPICS))
        self.check(recorder)

    def left(self, recorder: Recorder) -> bool:
        """Return whether nothing more is to be recorded; called again and again."""
        return False

    def check(self, recorder: Recorder) -> None:
        """Compare the files with the counts."""
        assert recorder.error is None or self.loses, recorder.error
        found = read(recorder.report.files)
        assert sum(map(len, found.values())) == recorder.report.messages
        for name, topic in recorder.topics.items():
            numbers = found.get(name, [])
            assert len(numbers) == topic.written, f"{name}: {numbers} in the files, {topic}"
            assert numbers == sorted(set(numbers)), f"{name}: {numbers}"
            assert self.loses or not topic.dropped
            assert self.loses or numbers == list(range(len(numbers))), f"{name}: {numbers}"
            assert self.enough != len(TOPICS) * MESSAGES or topic.messages == MESSAGES


class RecordingEnded(Recording):
    """It ends while messages come: those that came before are there."""

    enough = 4


class RecordingDropping(Recording):
    """There is room for few messages: the oldest are dropped."""

    settings = {"buffer_size": 3 * (SIZE + MESSAGE_OVERHEAD)}
    loses = True


class RecordingSplit(Recording):
    """A new file begins after each few messages."""

    settings = {"split": True, "max_size": EMPTY_BAG_SIZE + 2 * SIZE}
    enough = 9


class RecordingToLimit(Recording):
    """The recording ends by itself when the file is large enough; what comes later counts."""

    settings = {"max_size": EMPTY_BAG_SIZE + 5 * SIZE}
    enough = 1000


class RecordingSome(Recording):
    """Three messages of each topic."""

    settings = {"limit": 3}
    enough = 6

    def left(self, recorder: Recorder) -> bool:
        """Leave topics of which enough has come."""
        return recorder.unsubscribe_finished()

    def check(self, recorder: Recorder) -> None:
        """Compare the files with the counts, and these with the limit."""
        super().check(recorder)
        assert [topic.written for topic in recorder.topics.values()] == [3, 3]


class FullFile(FileIO):
    """A file on a disk that is full soon."""

    room = EMPTY_BAG_SIZE + 1500

    def write(self, data: Any) -> int:
        """Write as much as there is room for."""
        left = self.room - self.tell()
        if left <= 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return super().write(data[:left])


class RecordingFull(Recording):
    """The disk becomes full: the file is complete, and what did not fit counts as dropped."""

    settings = {"chunk_size": 2 * SIZE}
    limits = (*Recording.limits, ("pyros1.bag.format.writer", "FileIO", FullFile))
    enough = 8
    loses = True


class Snapping(Scenario):
    """Snapshots of the last messages, also two at a time: each has, of each topic, the last ones that had come."""

    modules = ("pyros1.bag.record.snapshot", "pyros1.bag.record.file", "pyros1.bag.record.model")
    kept = 3

    def play(self, stage: Stage) -> None:
        """Play it."""
        with tempfile.TemporaryDirectory() as folder:
            self.act(stage, Path(folder))

    def act(self, stage: Stage, folder: Path) -> None:
        """Play it, with files there."""
        source: Any = Source()
        names = FileNames(str(folder / "s"), has_date=False)
        snapshots = SnapshotBuffer(
            source,
            RecordOptions(names=names, min_space=0),
            0.0,
            self.kept * (SIZE + MESSAGE_OVERHEAD),
            lambda text: None,
        )
        for name in TOPICS:
            snapshots.subscribe(name)
        files: list[str] = []

        def snap() -> None:
            for _ in range(2):
                stage.time.sleep(60e-6)
                before = {name: topic.messages for name, topic in snapshots.topics.items()}
                path, count = snapshots.write()
                if not path:
                    continue
                files.append(path)
                found = read([path])
                assert count == sum(map(len, found.values()))
                for name in TOPICS:
                    numbers = found.get(name, []) or [-1]
                    assert numbers == list(range(numbers[0], numbers[0] + len(numbers))), f"{name}: {numbers}"
                    assert len(numbers) <= self.kept and numbers[-1] >= before[name] - 2, f"{name}: {numbers}, {before}"

        stage.together(snap, snap, *(source.publish(stage, name) for name in TOPICS))
        assert len(set(files)) == len(files), "one snapshot took the place of another"
        path, count = snapshots.write()
        last = list(range(MESSAGES - self.kept, MESSAGES))
        assert read([path]) == dict.fromkeys(TOPICS, last) and count == len(TOPICS) * self.kept


def read(paths: list[str]) -> dict[str, list[int]]:
    """Return the numbers of the messages of each topic, in the order of the files."""
    found: dict[str, list[int]] = {}
    for path in paths:
        with BagReader(path) as bag:
            for message in bag.messages():
                found.setdefault(message.connection.topic, []).append(int.from_bytes(bytes(message.data[:4]), "little"))
    return found
