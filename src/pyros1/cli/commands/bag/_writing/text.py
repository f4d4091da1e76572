"""Text formats of ``bag export``: CSV as printed by ``topic echo -b -p``, and JSON lines."""

from __future__ import annotations

import json
import os
from contextlib import ExitStack
from typing import Any, TextIO

from pyros1.bag.export.file_names import TopicFileNames
from pyros1.bag.export.tables import Table
from pyros1.cli.clean_output import data_stream
from pyros1.cli.failures import CommandError
from pyros1.cli.shared.buffered_output import BufferedOutput
from pyros1.cli.shared.output_formats import JsonFormat
from pyros1.ground.timing import Time
from pyros1.msgs import Message

STDOUT_TARGET = "-"


class CsvWriter:
    """Writes one CSV file per topic. The first row contains the column names.

    Args:
        target: The folder to create; a file if the name ends with ``.csv``; ``-`` for standard output.
        topics: The topics to write; if the target is a file, only one.
        options: The parsed options. ``nostr`` and ``noarr`` leave out strings and arrays.

    Raises:
        CommandError: The target is a file, but there is more than one topic.
    """

    def __init__(self, target: str, topics: list[str], options: Any) -> None:
        self._folder = "" if target == STDOUT_TARGET or target.lower().endswith(".csv") else target
        self._target = target
        if self._folder:
            os.mkdir(self._folder)
        elif len(topics) > 1:
            raise CommandError(
                f"a CSV file holds one topic, but {len(topics)} are selected: select one with --topics, "
                "or give a folder as output"
            )
        self._table = Table(omits_strings=bool(options.nostr), omits_arrays=bool(options.noarr))
        self._names = TopicFileNames()
        self._files: dict[str, TextIO] = {}
        self._exit_stack = ExitStack()

    def write_message(self, topic: str, message: Message, time: Time) -> None:
        """Write a message as a row of its topic's file."""
        file = self._files.get(topic)
        is_new = file is None
        if file is None:
            file = self._files[topic] = self._open(topic)
        with BufferedOutput(file.write) as out:
            if is_new:
                self._table.emit_header(message, out.add)
            self._table.emit_message(message, time.to_nsec(), out.add)

    def close(self) -> None:
        """Close the files. If the target is a single file, it is created even if no message was written."""
        if not self._folder and not self._files and self._target != STDOUT_TARGET:
            self._open("")
        self._exit_stack.close()

    def abort(self) -> None:
        """Close the files without completing them."""
        self._exit_stack.close()

    def _open(self, topic: str) -> TextIO:
        if self._target == STDOUT_TARGET:
            return data_stream()
        path = os.path.join(self._folder, f"{self._names[topic]}.csv") if self._folder else self._target
        return self._exit_stack.enter_context(open(path, "w", encoding="utf-8", newline=""))


class JsonWriter:
    """Writes one line of JSON per message: ``{"topic": ..., "time": {...}, "type": ..., "message": {...}}``.

    Args:
        target: The file; ``-`` for standard output.
        options: The parsed options. ``nostr`` and ``noarr`` leave out strings and arrays; ``bare`` writes the
            messages only.
    """

    def __init__(self, target: str, options: Any) -> None:
        self._writes_only_messages = bool(options.bare)
        self._write_json = JsonFormat(options)
        self._owns_file = target != STDOUT_TARGET
        self._file = open(target, "w", encoding="utf-8", newline="") if self._owns_file else data_stream()  # noqa: SIM115
        self._prefixes: dict[str, str] = {}

    def write_message(self, topic: str, message: Any, time: Time) -> None:
        """Write a message as a line of JSON."""
        if self._writes_only_messages:
            self._write_json(message, message, None, self._file.write)
            return
        prefix = self._prefixes.get(topic)
        if prefix is None:
            prefix = self._prefixes[topic] = f'{{"topic": {json.dumps(topic)}, "type": {json.dumps(message._type)}'
        stamp = f'"time": {{"secs": {time.secs}, "nsecs": {time.nsecs}}}'
        self._file.write(f'{prefix}, {stamp}, "message": ')
        self._write_json(message, message, None, self._file.write, "}\n")

    def close(self) -> None:
        """Close the file."""
        if self._owns_file:
            self._file.close()

    def abort(self) -> None:
        """Close the file without completing it."""
        self.close()
