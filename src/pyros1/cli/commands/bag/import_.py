"""``bag import``: converts ROS 2 bags and MCAP files to bags."""

from __future__ import annotations

import fnmatch
import os
import sys
from typing import Any

from pyros1.cli.commands.bag._options import QUIET_FLAG, TOPICS_OPTION, compression_options, split_on_commas
from pyros1.cli.commands.bag._writing.files import check_different, write_atomically
from pyros1.cli.failures import CommandError, UsageError, did_you_mean
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Flag, Option, Verb
from pyros1.cli.shared.options import CHUNK_LIMIT_OPTION
from pyros1.cli.shared.progress import Progress


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Write a bag with the messages from a ROS 2 bag or MCAP file."""
    if len(args) != 1:
        raise UsageError("You must specify one ROS 2 bag or MCAP file.")
    source = os.path.normpath(args[0])
    target = options.output or os.path.splitext(source)[0] + ".bag"
    check_different(source, target)
    patterns = split_on_commas(options.topics)
    known_topics: list[str] = []

    def is_selected(topic: str) -> bool:
        known_topics.append(topic)
        name = topic.lstrip("/")
        return not patterns or any(fnmatch.fnmatchcase(name, pattern.lstrip("/")) for pattern in patterns)

    from pyros1.bag.export.imports import import_bag  # noqa: PLC0415 - not needed for help

    with (
        write_atomically(target, is_folder=False, force=bool(options.force)) as temporary_path,
        Progress(target, _size_in_bytes(source), quiet=options.quiet) as progress,
    ):
        result = import_bag(
            source, temporary_path, compression=options.compression, is_selected=is_selected, progress=progress
        )
        if patterns and not result.topics:
            hint = did_you_mean(patterns[0], known_topics)
            raise CommandError(f"no topic {' '.join(patterns)} in {source}{hint}")
        if not result.messages:
            reasons = "".join(f"; {topic} is left out: {reason}" for topic, reason in result.skipped.items())
            raise CommandError(f"no messages in {source}{reasons}; {target} was not written")
    for topic, reason in result.skipped.items():
        print(f"WARNING: {topic} is left out: {reason}", file=sys.stderr)
    if not options.quiet:
        print(f"{target}: {result.messages} messages of {result.topics} topic{'s' if result.topics != 1 else ''}")


VERB = Verb(
    "import",
    "convert a ROS 2 bag or MCAP file to a bag",
    CHUNK_LIMIT_OPTION,
    Option("-o", "--output", metavar="OUT", help="the bag to write (default: SOURCE.bag)"),
    Flag("-f", "--force", help="replace the bag if it exists"),
    QUIET_FLAG,
    TOPICS_OPTION,
    *compression_options("none"),
    Argument("SOURCE", "file"),
    description="Convert a ROS 2 bag to a ROS 1 bag. SOURCE is the folder of the ROS 2 bag, or an .mcap or .db3 file. "
    "An .mcap file may also contain ROS 1 messages.",
    examples=[
        ("run.mcap -o run.bag", "convert an MCAP file of ROS 1 or ROS 2"),
        ("rosbag2_folder", "convert a ROS 2 bag to rosbag2_folder.bag"),
    ],
    stock="",
    run=run,
)


def _size_in_bytes(source: str) -> int:
    if not os.path.isdir(source):
        return os.path.getsize(source) if os.path.exists(source) else 0
    return sum(entry.stat().st_size for entry in os.scandir(source) if entry.is_file())
