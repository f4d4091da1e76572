"""``bag export``: writes bags as CSV, JSON, images, videos, MCAP or a ROS 2 bag."""

from __future__ import annotations

import heapq
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import replace
from typing import Any

from pyros1.bag.api import Bag
from pyros1.bag.edit.editing import MessageSelection
from pyros1.bag.format.reader import RawMessage
from pyros1.bag.format.records import Connection
from pyros1.cli.commands.bag._options import QUIET_FLAG, SELECTION_OPTIONS, make_selection
from pyros1.cli.commands.bag._writing.files import check_different, write_atomically
from pyros1.cli.failures import CommandError, UsageError, did_you_mean
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Flag, Option, Verb
from pyros1.cli.shared.options import CHUNK_LIMIT_OPTION
from pyros1.cli.shared.progress import Progress
from pyros1.ground.errors import MessageError
from pyros1.ground.timing import Time

SUFFIXES_BY_FORMAT = {
    "csv": "_csv",
    "jsonl": ".jsonl",
    "images": "_images",
    "video": "_video",
    "mcap": ".mcap",
    "ros2": "_ros2",
}
"""The formats, each with the default suffix of the output's name."""

_FORMATS_BY_EXTENSION = {
    ".csv": "csv",
    ".jsonl": "jsonl",
    ".ndjson": "jsonl",
    ".mcap": "mcap",
    ".mp4": "video",
    ".mkv": "video",
    ".avi": "video",
    ".mov": "video",
}
_STDOUT_TARGET = "-"
_DEFAULT_DISTRIBUTION = "jazzy"
_MAX_SKIPPED_SHOWN = 5
_MAX_NAMES_SHOWN = 20


def run(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Write the contents of bags in a format for other programs. Return 1 if messages were left out, otherwise 0."""
    if not args:
        raise UsageError("You must specify at least one bag file.")
    format_name = _select_format(options)
    target = options.output or os.path.splitext(args[0])[0] + SUFFIXES_BY_FORMAT[format_name]
    for path in args:
        check_different(path, target)
    with ExitStack() as exit_stack:
        bags = [exit_stack.enter_context(Bag(path, unindexed=False)) for path in args]
        first_bag = min(bags, key=lambda bag: bag.reader.start or sys.maxsize)
        export = _Export(
            bags, make_selection(options, first_bag.reader), only_images=format_name in ("images", "video")
        )
        temporary_path = target
        if target != _STDOUT_TARGET:
            is_folder = (
                format_name in ("csv", "images", "video", "ros2") and _extension(target) not in _FORMATS_BY_EXTENSION
            )
            temporary_path = exit_stack.enter_context(
                write_atomically(target, is_folder=is_folder, force=bool(options.force))
            )
        writer = _make_writer(format_name, temporary_path, export.topics, options)
        exit_stack.callback(writer.abort)
        progress = exit_stack.enter_context(
            Progress(target, export.size, quiet=options.quiet or target == _STDOUT_TARGET)
        )
        count = export.write_to(writer, progress)
        if not count and not export.skipped:
            raise CommandError(f"no messages between the selected times in {', '.join(args)}")
        writer.close()
    for text in (*export.skipped_warnings(), *_renaming_notes(writer)):
        print(text, file=sys.stderr)
    if target != _STDOUT_TARGET and not options.quiet:
        print(f"{target}: {count} messages of {len(export.topics)} topic{'s' if len(export.topics) != 1 else ''}")
    return 1 if export.skipped else 0


VERB = Verb(
    "export",
    "write CSV, JSON, images, videos, MCAP files or ROS 2 bags",
    CHUNK_LIMIT_OPTION,
    Option(
        "--format",
        choices=list(SUFFIXES_BY_FORMAT),
        metavar="F",
        help="csv: one table per topic, as `topic echo -b -p` prints it; jsonl: one line of JSON per message; "
        "images: image files; video: one video per topic; mcap: an MCAP file with ROS 2 messages, or ROS 1 messages "
        "with --ros1; ros2: a ROS 2 bag. Names that ROS 2 does not allow are changed: timeStamp to time_stamp, package "
        "Mocap to mocap. Default: determined by the output's extension",
    ),
    Option(
        "-o",
        "--output",
        metavar="OUT",
        help="file or folder to write; - is standard output, for JSON or for CSV of one topic",
    ),
    Flag("-f", "--force", help="replace existing files"),
    QUIET_FLAG,
    *SELECTION_OPTIONS,
    Flag("--nostr", help="csv, jsonl: leave out strings"),
    Flag("--noarr", help="csv, jsonl: leave out arrays"),
    Flag("--bare", help="jsonl: messages only, without topic and time"),
    Flag("--mosaic", help="images: keep raw Bayer images instead of converting them to color"),
    Option(
        "--storage",
        choices=["sqlite3", "mcap"],
        default="sqlite3",
        help="ros2: storage format of the bag, sqlite3 or mcap",
    ),
    Option(
        "--distro",
        default=_DEFAULT_DISTRIBUTION,
        metavar="D",
        help=f"ros2, mcap: the ROS 2 distribution whose types are used (default {_DEFAULT_DISTRIBUTION})",
    ),
    Flag(
        "--ros1",
        help="mcap: keep ROS 1 messages instead of converting them to ROS 2; `bag import` reads both",
    ),
    Argument("BAGFILE", "bag", repeatable=True),
    usage="[options] BAGFILE1 [BAGFILE2 ...]",
    description="Write the contents of bags in a format for other programs.",
    examples=[
        ("run.bag --format csv --topics /odom,/imu", "write the tables run_csv/odom.csv and run_csv/imu.csv"),
        ("run.bag -o - --format jsonl | jq .message", "print lines of JSON for other programs"),
        ("run.bag --format images -o frames", "write image files, named after the time stamps of the images"),
        ("run.bag -o camera.mp4 --topics /camera/image_raw --from 10 --to 20", "write a video"),
        ("a.bag b.bag -o run.mcap", "convert two bags to one file for Foxglove"),
        ("run.bag -o run.mcap --ros1", "keep the messages unchanged, like `mcap convert`"),
        ("run.bag --format ros2", "write a bag for `ros2 bag play run_ros2`"),
    ],
    stock="",
    run=run,
)


def _renaming_notes(writer: Any) -> Iterator[str]:
    """Yield notes about names that were changed because ROS 2 does not allow them."""
    new_names = writer.names.renamed if hasattr(writer, "names") else {}
    for old_name, new_name in list(new_names.items())[:_MAX_NAMES_SHOWN]:
        yield f"NOTE: {old_name} was renamed to {new_name}: ROS 2 does not allow the old name"
    if len(new_names) > _MAX_NAMES_SHOWN:
        yield f"NOTE: {len(new_names) - _MAX_NAMES_SHOWN} more names were changed"


def _select_format(options: Any) -> str:
    output = options.output
    guessed_format = _FORMATS_BY_EXTENSION.get(_extension(output)) if output else None
    if options.format is None and guessed_format is None:
        raise UsageError("You must specify --format, or an output whose name ends with .csv, .jsonl, .mcap or .mp4")
    format_name = str(options.format or guessed_format)
    if guessed_format is not None and guessed_format != format_name:
        raise UsageError(f"--format {format_name} does not match the output name {output}")
    if output == _STDOUT_TARGET and format_name not in ("csv", "jsonl"):
        raise UsageError(f"--format {format_name} needs a file or folder as output")
    if options.ros1 and format_name != "mcap":
        raise UsageError(f"--ros1 needs --format mcap, not {format_name}")
    return format_name


def _extension(path: str) -> str:
    return os.path.splitext(path)[1].lower()


def _make_writer(format_name: str, temporary_path: str, topics: list[str], options: Any) -> Any:
    if format_name in ("csv", "jsonl"):
        # Only the modules that the format needs are imported.
        from pyros1.cli.commands.bag._writing.text import CsvWriter, JsonWriter  # noqa: PLC0415

        return (
            CsvWriter(temporary_path, topics, options) if format_name == "csv" else JsonWriter(temporary_path, options)
        )
    if format_name == "images":
        from pyros1.bag.export.image_files import ImageFileWriter  # noqa: PLC0415

        return ImageFileWriter(temporary_path, mosaic=bool(options.mosaic))
    if format_name == "video":
        from pyros1.bag.export.video import VideoWriter  # noqa: PLC0415

        return VideoWriter(_make_video_path(temporary_path, topics))
    if options.ros1:
        from pyros1.bag.export.mcap_writer import Ros1McapWriter  # noqa: PLC0415

        return Ros1McapWriter(temporary_path)
    from pyros1.bag.export.ros2 import Ros2McapWriter, Ros2Writer  # noqa: PLC0415
    from pyros1.bag.export.rosbags_types import distributions  # noqa: PLC0415

    if options.distro not in distributions():
        hint = did_you_mean(options.distro, distributions())
        raise CommandError(
            f"--distro: unknown distribution {options.distro!r}{hint or '; known: ' + ', '.join(distributions())}", 2
        )
    if format_name == "mcap":
        return Ros2McapWriter(temporary_path, options.distro)
    return Ros2Writer(temporary_path, options.storage, options.distro)


def _make_video_path(temporary_path: str, topics: list[str]) -> Callable[[str], str]:
    from pyros1.bag.export.file_names import TopicFileNames  # noqa: PLC0415

    if _extension(temporary_path) in _FORMATS_BY_EXTENSION:
        if len(topics) > 1:
            raise CommandError(
                f"a video shows one topic, but {len(topics)} are selected: select one with --topics, "
                "or give a folder as output"
            )
        return lambda topic: temporary_path
    os.mkdir(temporary_path)
    file_names = TopicFileNames()
    return lambda topic: os.path.join(temporary_path, f"{file_names[topic]}.mp4")


class _Export:
    """Passes the selected messages to a writer.

    Args:
        bags: The open bags.
        selection: The selected topics and times.
        only_images: Whether to export only topics with images.

    Attributes:
        topics: The sorted names of the topics with selected messages.
        size: The size of the bags' contents in bytes.
        skipped: The number of messages left out, by topic and reason.

    Raises:
        CommandError: No message is selected.
    """

    def __init__(self, bags: list[Bag], selection: MessageSelection, *, only_images: bool) -> None:
        self._bags = bags
        self._selection = selection
        self._bags_by_connection_id = {id(connection): bag for bag in bags for connection in bag.connections}
        types = _image_types() if only_images else None
        self._usable_connections: dict[int, Connection] = {}
        self._connection_ids = [_connections_with_messages(bag, selection, types) for bag in bags]
        bags_and_ids = zip(bags, self._connection_ids, strict=True)
        self.topics = sorted(
            {bag.reader.connections[connection_id].topic for bag, ids in bags_and_ids for connection_id in ids}
        )
        if not self.topics:
            raise CommandError(self._no_messages_text(only_images))
        known_topics = {topic for bag in bags for topic in bag.topics}
        for name in selection.topics:
            if not any(MessageSelection([name]).connections(bag.reader) for bag in bags):
                raise CommandError(f"no topic {name} in {bags[0].path}{did_you_mean(name, known_topics)}")
        self.size = sum(bag.reader.header(chunk).size for bag in bags for chunk in bag.reader.chunks)
        self.skipped: dict[str, dict[str, int]] = {}

    def write_to(self, writer: Any, progress: Callable[[int], object]) -> int:
        """Write all selected messages. Return the number of messages written.

        Args:
            writer: An object with a method `write_raw` for stored messages, or `write_message` for decoded ones.
            progress: Called with the number of bytes processed so far, out of `size`.

        Raises:
            BagError: A bag cannot be read, or a message cannot be converted.
            OSError: The output cannot be written, for example because the disk is full.
        """
        accepts_raw_messages = hasattr(writer, "write_raw")
        begin = max(min(bag.reader.start for bag in self._bags), self._selection.start or 0)
        end = min(max(bag.reader.end for bag in self._bags), self._selection.end or sys.maxsize)
        bytes_per_nanosecond = self.size / max(1, end - begin)
        count = 0
        for raw_message in self._messages():
            progress(int((raw_message.time - begin) * bytes_per_nanosecond))
            if accepts_raw_messages:
                writer.write_raw(self._with_usable_definition(raw_message))
                count += 1
                continue
            topic = raw_message.connection.topic
            message = self._bags_by_connection_id[id(raw_message.connection)].decode(raw_message)
            try:
                writer.write_message(topic, message, Time.from_nsec(raw_message.time))
                count += 1
            except MessageError as error:
                reasons = self.skipped.setdefault(topic, {})
                reasons[str(error)] = reasons.get(str(error), 0) + 1
            del raw_message, message  # a message may be large, and must not stay in memory while the next one is read
        return count

    def _with_usable_definition(self, raw_message: RawMessage) -> RawMessage:
        """Return the message with a definition that other programs can read, if one is known."""
        connection = raw_message.connection
        if id(connection) not in self._usable_connections:
            definition = self._bags_by_connection_id[id(connection)].definition(connection)
            header = {**connection.header, "message_definition": definition.encode("utf-8", "surrogateescape")}
            is_same = definition == connection.definition
            self._usable_connections[id(connection)] = connection if is_same else replace(connection, header=header)
        usable_connection = self._usable_connections[id(connection)]
        return raw_message if usable_connection is connection else raw_message._replace(connection=usable_connection)

    def skipped_warnings(self) -> Iterator[str]:
        """Yield warnings about messages that were left out."""
        for topic, reasons in self.skipped.items():
            for reason, count in list(reasons.items())[:_MAX_SKIPPED_SHOWN]:
                yield f"WARNING: {topic}: {count} message{'s' if count > 1 else ''} left out: {reason}"
            if len(reasons) > _MAX_SKIPPED_SHOWN:
                yield f"WARNING: {topic}: more messages left out, for {len(reasons) - _MAX_SKIPPED_SHOWN} other reasons"

    def _messages(self) -> Iterator[RawMessage]:
        start, end = self._selection.start, self._selection.end
        streams = [
            bag.reader.messages(ids, start, end) for bag, ids in zip(self._bags, self._connection_ids, strict=True)
        ]
        return streams[0] if len(streams) == 1 else heapq.merge(*streams, key=lambda stored: stored.time)

    def _no_messages_text(self, only_images: bool) -> str:
        bag_names = ", ".join(bag.path for bag in self._bags)
        topics = {topic for bag in self._bags for topic in bag.topics}
        if not topics:
            return f"no messages in {bag_names}"
        for name in self._selection.topics:
            if not any(MessageSelection([name]).connections(bag.reader) for bag in self._bags):
                return f"no topic {name} in {bag_names}{did_you_mean(name, topics)}"
        selection = self._selection
        has_selection = selection.topics or selection.drop or selection.start is not None or selection.end is not None
        time_range = " for the selected topics and times" if has_selection else ""
        return f"no {'images' if only_images else 'messages'}{time_range} in {bag_names}"


def _connections_with_messages(
    bag: Bag, selection: MessageSelection, accepted_types: tuple[str, ...] | None
) -> set[int]:
    """Return the ids of the selected connections that have messages between the selected times.

    Args:
        bag: The open bag.
        selection: The selected topics and times.
        accepted_types: The accepted message types; None for all.
    """
    used_ids = {
        connection_id
        for chunk in bag.reader.chunks
        if (selection.start is None or chunk.end >= selection.start)
        and (selection.end is None or chunk.start <= selection.end)
        for connection_id in chunk.counts
    }
    ids = selection.connections(bag.reader) & used_ids
    return {
        connection_id
        for connection_id in ids
        if accepted_types is None or bag.reader.connections[connection_id].type in accepted_types
    }


def _image_types() -> tuple[str, ...]:
    from pyros1.bag.export.image_files import IMAGE_TYPES  # noqa: PLC0415 - numpy is slow to import

    return IMAGE_TYPES
