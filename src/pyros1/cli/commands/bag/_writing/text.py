"""``bag export``: CSV as ``topic echo -b -p`` prints it, and lines of JSON."""

from __future__ import annotations

import json
import os
from contextlib import ExitStack
from typing import Any, TextIO

from pyros1.bag.export.tables import Table
from pyros1.bag.export.topic_names import FileNames
from pyros1.cli.clean_output import data_stream
from pyros1.cli.failures import CommandError
from pyros1.cli.shared.buffered_output import BufferedOutput
from pyros1.cli.shared.forms import Json
from pyros1.ground.timing import Time
from pyros1.msgs import Message

STDOUT = "-"


class CsvWriter:
    """Writes a file of comma-separated values per topic. The first row has the names of the columns.

    Args:
        target: the folder, which is created; a file if the name ends with ``.csv``; ``-`` for standard output.
        topics: the topics to write. A file contains a single topic.
        options: ``nostr`` and ``noarr`` leave out texts and arrays.

    Raises:
        CommandError: the target is a file, and there is more than one topic.
    """

    def __init__(self, target: str, topics: list[str], options: Any) -> None:
        self._folder = "" if target == STDOUT or target.lower().endswith(".csv") else target
        self._target = target
        if self._folder:
            os.mkdir(self._folder)
        elif len(topics) > 1:
            raise CommandError(
                f"a CSV file holds one topic, but {len(topics)} are selected: select one with --topics, "
                "or give a folder as output"
            )
        self._table = Table(nostr=bool(options.nostr), noarr=bool(options.noarr))
        self._names = FileNames()
        self._files: dict[str, TextIO] = {}
        self._stack = ExitStack()

    def write_message(self, topic: str, message: Message, time: Time) -> None:
        """Write a row."""
        file = self._files.get(topic)
        new = file is None
        if file is None:
            file = self._files[topic] = self._open(topic)
        with BufferedOutput(file.write) as out:
            if new:
                self._table.head(message, out.add)
            self._table.row(message, time.to_nsec(), out.add)

    def close(self) -> None:
        """Close the files."""
        if not self._folder and not self._files and self._target != STDOUT:
            self._open("")
        self._stack.close()

    def abort(self) -> None:
        """Close the files without completing them."""
        self._stack.close()

    def _open(self, topic: str) -> TextIO:
        if self._target == STDOUT:
            return data_stream()
        path = os.path.join(self._folder, f"{self._names[topic]}.csv") if self._folder else self._target
        return self._stack.enter_context(open(path, "w", encoding="utf-8", newline=""))


class JsonWriter:
    """Writes a line of JSON per message: ``{"topic": ..., "time": {...}, "type": ..., "message": {...}}``.

    Args:
        target: the file; ``-`` for standard output.
        options: ``nostr`` and ``noarr`` leave out texts and arrays; ``bare`` writes the messages only.
    """

    def __init__(self, target: str, options: Any) -> None:
        self._bare = bool(options.bare)
        self._json = Json(options)
        self._own = target != STDOUT
        self._file = open(target, "w", encoding="utf-8", newline="") if self._own else data_stream()  # noqa: SIM115
        self._heads: dict[str, str] = {}

    def write_message(self, topic: str, message: Any, time: Time) -> None:
        """Write a line."""
        if self._bare:
            self._json(message, message, None, self._file.write)
            return
        head = self._heads.get(topic)
        if head is None:
            head = self._heads[topic] = f'{{"topic": {json.dumps(topic)}, "type": {json.dumps(message._type)}'
        stamp = f'"time": {{"secs": {time.secs}, "nsecs": {time.nsecs}}}'
        self._file.write(f'{head}, {stamp}, "message": ')
        self._json(message, message, None, self._file.write, "}\n")

    def close(self) -> None:
        """Close the file."""
        if self._own:
            self._file.close()

    def abort(self) -> None:
        """Close the file without completing it."""
        self.close()
