"""``bag import``: bags of ROS 2 bags and MCAP files."""

from __future__ import annotations

import fnmatch
import os
import sys
from typing import Any

from pyros1.cli.commands.bag._options import QUIET, TOPICS, compression, parted
from pyros1.cli.commands.bag._writing.files import different, whole_or_nothing
from pyros1.cli.failures import CommandError, UsageError, did_you_mean
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Flag, Option, Verb
from pyros1.cli.shared.options import CHUNK_LIMIT_OPTION
from pyros1.cli.shared.progress import Progress


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Write a bag with the messages of a ROS 2 bag or MCAP file."""
    if len(args) != 1:
        raise UsageError("You must specify one ROS 2 bag or MCAP file.")
    source = os.path.normpath(args[0])
    target = options.output or os.path.splitext(source)[0] + ".bag"
    different(source, target)
    patterns = parted(options.topics)
    there: list[str] = []

    def wanted(topic: str) -> bool:
        there.append(topic)
        name = topic.lstrip("/")
        return not patterns or any(fnmatch.fnmatchcase(name, pattern.lstrip("/")) for pattern in patterns)

    from pyros1.bag.export.imports import import_bag  # noqa: PLC0415 - `bag import -h` needs none of it

    with (
        whole_or_nothing(target, folder=False, force=bool(options.force)) as part,
        Progress(target, _size(source), quiet=options.quiet) as progress,
    ):
        done = import_bag(source, part, compression=options.compression, wanted=wanted, progress=progress)
        if patterns and not done.topics:
            hint = did_you_mean(patterns[0], there)
            raise CommandError(f"there is no topic {' '.join(patterns)} in {source}{hint}")
        if not done.messages:
            reasons = "".join(f"; {topic} is left out: {reason}" for topic, reason in done.skipped.items())
            raise CommandError(f"there are no messages in {source}{reasons}; {target} was not written")
    for topic, reason in done.skipped.items():
        print(f"WARNING: {topic} is left out: {reason}", file=sys.stderr)
    if not options.quiet:
        print(f"{target}: {done.messages} messages of {done.topics} topic{'s' if done.topics != 1 else ''}")


VERB = Verb(
    "import",
    "make a bag of a ROS 2 bag or MCAP file",
    CHUNK_LIMIT_OPTION,
    Option("-o", "--output", metavar="OUT", help="the bag to write; without it SOURCE.bag"),
    Flag("-f", "--force", help="replace the bag if it is there"),
    QUIET,
    TOPICS,
    *compression("none"),
    Argument("SOURCE", "file"),
    description="Make a bag of a ROS 2 bag: its folder, or an .mcap or .db3 file; or of an .mcap file with messages of "
    "ROS 1.",
    examples=[("run.mcap -o run.bag", "of ROS 1 or ROS 2"), ("rosbag2_folder", "into rosbag2_folder.bag")],
    stock="",
    run=run,
)


def _size(source: str) -> int:
    if not os.path.isdir(source):
        return os.path.getsize(source) if os.path.exists(source) else 0
    return sum(entry.stat().st_size for entry in os.scandir(source) if entry.is_file())
