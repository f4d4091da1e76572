"""``bag import``: bags of ROS 2 bags and MCAP files."""

from __future__ import annotations

import fnmatch
import os
import sys

from pyros1.cli.bag_edit import add_compression
from pyros1.cli.bag_export_files import whole_or_nothing
from pyros1.cli.bag_files import different
from pyros1.cli.common import CommandError, Invocation, did_you_mean
from pyros1.cli.shared.progress import Progress


def import_(invocation: Invocation) -> None:
    """``bag import SOURCE -o OUT.bag``."""
    parser = invocation.parser("import [options] SOURCE")
    parser.description = (
        "Make a bag of a ROS 2 bag: its folder, or an .mcap or .db3 file; or of an .mcap file with messages of ROS 1."
    )
    parser.add_option("-o", "--output", metavar="OUT", help="the bag to write; without it SOURCE.bag")
    parser.add_option("-f", "--force", action="store_true", help="replace the bag if it is there")
    parser.add_option("-q", "--quiet", action="store_true", help="suppress noncritical messages")
    parser.add_option(
        "--topics",
        action="append",
        default=[],
        metavar="T1,T2",
        help="only these topics, separated by commas; * stands for any characters. Can be given several times",
    )
    add_compression(parser, "none")
    options, args = parser.parse_args(invocation.args)
    if len(args) != 1:
        parser.error("You must specify one ROS 2 bag or MCAP file.")
    source = os.path.normpath(args[0])
    target = options.output or os.path.splitext(source)[0] + ".bag"
    different(source, target)
    patterns = [word for text in options.topics for word in text.split(",") if word]
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


def _size(source: str) -> int:
    if not os.path.isdir(source):
        return os.path.getsize(source) if os.path.exists(source) else 0
    return sum(entry.stat().st_size for entry in os.scandir(source) if entry.is_file())
