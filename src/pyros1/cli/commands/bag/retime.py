"""``bag retime``: copies a bag with other message times."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from pyros1.bag.api import Bag
from pyros1.bag.edit import editing as edit
from pyros1.bag.format.reader import RawMessage
from pyros1.cli.commands.bag._options import compression_options, parse_time
from pyros1.cli.commands.bag._writing.files import check_different, new_file
from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Flag, Option, Verb
from pyros1.cli.shared.options import CHUNK_LIMIT_OPTION
from pyros1.cli.shared.progress import Progress
from pyros1.ground.timing import Time


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Write a copy of a bag with changed message times."""
    _check_options(options, args)
    source, target = args
    check_different(source, target)
    with Bag(source, unindexed=False) as bag:
        if options.header_stamp:
            retime = _make_stamp_reader(bag)
        else:
            offset = parse_time(options.offset, None, "--offset") if options.offset is not None else 0
            if options.start is not None:
                offset = parse_time(options.start, bag.reader, "--start") - bag.reader.start
            retime = edit.time_shifter(offset, options.rate, bag.reader.start)
        with new_file(target) as temporary_path, Progress(target, bag.reader.content_size()) as progress:
            count = edit.copy(
                bag.reader.messages(),
                temporary_path,
                compression=options.compression,
                cipher=bag.reader.file.cipher,
                retime=retime,
                progress=progress,
            )
    print(f"{target}: {count} messages")


VERB = Verb(
    "retime",
    "change the times at which messages were recorded",
    CHUNK_LIMIT_OPTION,
    Option("--offset", metavar="SEC", help="add SEC seconds to all times"),
    Option("--start", metavar="TIME", help="make the bag start at TIME, in a form that `bag filter --from` accepts"),
    Option("--rate", type="float", default=1.0, metavar="F", help="divide the time between messages by F"),
    Flag("--header-stamp", help="use header stamps as times, for messages with a header"),
    *compression_options("none"),
    Argument("INBAG", "bag"),
    Argument("OUTBAG", "file"),
    usage="[options] INBAG OUTBAG",
    description="Change the times at which messages were recorded. The messages themselves do not change.",
    examples=[
        ("run.bag out.bag --offset -3600", "move the messages back by one hour"),
        ("run.bag out.bag --header-stamp", "use the times in the message headers"),
    ],
    stock="",
    run=run,
)


def _check_options(options: Any, args: list[str]) -> None:
    if len(args) != 2:
        raise UsageError("You must specify an in bag and an out bag.")
    if options.offset is not None and options.start is not None:
        raise UsageError("You can only specify one of --offset and --start.")
    if options.header_stamp and (options.offset or options.start or options.rate != 1.0):
        raise UsageError("--header-stamp cannot be combined with the other options")
    if not options.header_stamp and options.offset is None and options.start is None and options.rate == 1.0:
        raise UsageError("You must specify --offset, --start, --rate or --header-stamp.")
    if not 0 < options.rate < float("inf"):
        raise UsageError("--rate must be greater than 0")


def _make_stamp_reader(bag: Bag) -> Callable[[RawMessage], int]:
    def read_stamp(raw_message: RawMessage) -> int:
        header = getattr(bag.decode(raw_message), "header", None)
        header_stamp = getattr(header, "stamp", None)
        return header_stamp.to_nsec() if isinstance(header_stamp, Time) and header_stamp else raw_message.time

    return read_stamp
