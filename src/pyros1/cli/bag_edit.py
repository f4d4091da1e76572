"""``bag compress``, ``decompress``, ``reindex`` (L142, L143), ``merge``, ``split``, ``rename-topic`` and ``retime``."""

from __future__ import annotations

import contextlib
import os
import re
import sys
from collections.abc import Callable, Mapping
from optparse import OptionParser

from pyros1.bag import edit
from pyros1.bag.api import Bag
from pyros1.bag.errors import BagError
from pyros1.bag.reader import BagReader, RawMessage
from pyros1.bag.records import NS
from pyros1.bag.reindex import Saved
from pyros1.bag.reindex import reindex as reindex_bag
from pyros1.cli.bag_choice import add_choice, choice_of, warn_of_strangers
from pyros1.cli.bag_files import different, interruptible, new_file, parse_time, rewrite_each
from pyros1.cli.common import CommandError, Invocation, did_you_mean
from pyros1.cli.shared.progress import Progress
from pyros1.names import is_legal_name
from pyros1.timing import Time

_SHOWN_DAMAGES = 5


def add_compression(parser: OptionParser, default: str) -> None:
    """Add ``--bz2`` and ``--lz4``; `default` is the compression without them."""
    parser.add_option(
        "-j",
        "--bz2",
        action="store_const",
        dest="compression",
        const="bz2",
        default=default,
        help="use BZ2 compression",
    )
    parser.add_option("--lz4", action="store_const", dest="compression", const="lz4", help="use lz4 compression")


def in_place_parser(invocation: Invocation, about: str) -> OptionParser:
    """Return a parser for what makes a new bag of each one (`rewrite_each`)."""
    parser = invocation.parser(f"{invocation.verb} [options] BAGFILE1 [BAGFILE2 ...]")
    parser.description = about
    parser.add_option("--output-dir", metavar="DIR", help="write to directory DIR")
    parser.add_option("-f", "--force", action="store_true", help="force overwriting of backup file if it exists")
    parser.add_option("-q", "--quiet", action="store_true", help="suppress noncritical messages")
    return parser


def compress(invocation: Invocation) -> int:
    """``bag compress [options] BAG...``."""
    parser = in_place_parser(invocation, "Compress one or more bag files.")
    add_compression(parser, "bz2")
    return _recompress(invocation, parser)


def decompress(invocation: Invocation) -> int:
    """``bag decompress [options] BAG...``."""
    parser = in_place_parser(invocation, "Decompress one or more bag files.")
    parser.set_defaults(compression="none")
    return _recompress(invocation, parser)


def _recompress(invocation: Invocation, parser: OptionParser) -> int:
    options, paths = parser.parse_args(invocation.args)
    if not paths:
        parser.error("You must specify at least one bag file.")

    def operation(source: str, target: str) -> None:
        with BagReader(source) as bag, Progress(source, content_size(bag), quiet=options.quiet) as progress:
            cipher = bag.file.cipher
            edit.copy(bag.messages(), target, compression=options.compression, cipher=cipher, progress=progress)

    return rewrite_each(
        paths, operation, output_dir=options.output_dir, force=bool(options.force), quiet=bool(options.quiet)
    )


def content_size(bag: BagReader) -> int:
    """Return the bytes of all that is in a bag, before compression."""
    return sum(header.size for header in bag.headers())


def reindex(invocation: Invocation) -> int:
    """``bag reindex [options] BAG...``."""
    parser = in_place_parser(invocation, "Reindexes one or more bag files: saves what can be read of damaged ones.")
    options, paths = parser.parse_args(invocation.args)
    if not paths:
        parser.error("You must specify at least one bag file.")

    def operation(source: str, target: str) -> None:
        with Progress(source, os.path.getsize(source), quiet=options.quiet) as progress:
            saved = reindex_bag(source, target, progress)
        if not saved.messages:
            raise BagError(source, f"{_no_messages(saved)}; the file is left as it is")
        if options.quiet:
            return
        for damage in saved.damages[:_SHOWN_DAMAGES]:
            print(f"{source}: at byte {damage.offset}: {damage.reason}", file=sys.stderr)
        if len(saved.damages) > _SHOWN_DAMAGES:
            print(f"{source}: and {len(saved.damages) - _SHOWN_DAMAGES} more", file=sys.stderr)
        lost = f"; {saved.lost} have lost their connection record, or have an impossible time" if saved.lost else ""
        print(f"{source}: {saved.messages} messages{lost}")

    return rewrite_each(
        paths, operation, output_dir=options.output_dir, force=bool(options.force), quiet=bool(options.quiet)
    )


def _no_messages(saved: Saved) -> str:
    if saved.lost:
        return f"the {saved.lost} messages found in it have lost their connection record, or have an impossible time"
    reasons = "".join(f"; at byte {damage.offset}: {damage.reason}" for damage in saved.damages[:1])
    return f"no messages were found in it{reasons}"


def merge(invocation: Invocation) -> None:
    """``bag merge OUT IN...``."""
    parser = invocation.parser("merge [options] OUTBAG INBAG1 [INBAG2 ...]")
    parser.description = "Merge bags into one, by time."
    add_choice(parser)
    add_compression(parser, "none")
    options, args = parser.parse_args(invocation.args)
    if len(args) < 2:
        parser.error("You must specify an out bag and at least one in bag.")
    target, *sources = args
    for source in sources:
        different(source, target)
    with contextlib.ExitStack() as stack:
        bags = [stack.enter_context(BagReader(source)) for source in sources]
        first = min(bags, key=lambda bag: bag.start or sys.maxsize)
        choice = choice_of(options, first)
        warn_of_strangers(choice, bags)
        progress = stack.enter_context(Progress(target, sum(map(content_size, bags))))
        part = stack.enter_context(new_file(target))
        messages = edit.merged(bags, choice)
        cipher = next((bag.file.cipher for bag in bags if bag.file.cipher is not None), None)
        count = edit.copy(messages, part, compression=options.compression, cipher=cipher, progress=progress)
    print(f"{target}: {count} messages")


def split(invocation: Invocation) -> None:
    """``bag split [options] IN``."""
    parser = invocation.parser("split [options] INBAG")
    parser.description = "Split a bag into NAME_0.bag, NAME_1.bag, ... at every limit given."
    parser.add_option("--size", type="float", metavar="MB", help="begin another file after MB mebibytes")
    parser.add_option("--duration", metavar="SEC", help="begin another file after SEC seconds; also 5m, 2h")
    parser.add_option("--count", type="int", metavar="N", help="begin another file after N messages")
    parser.add_option("--repeat-latched", action="store_true", help="begin every file with the latched messages so far")
    parser.add_option("--output-dir", metavar="DIR", help="write to directory DIR")
    parser.add_option("-f", "--force", action="store_true", help="replace files of these names")
    add_choice(parser)
    add_compression(parser, "none")
    options, args = parser.parse_args(invocation.args)
    if len(args) != 1:
        parser.error("You must specify one bag.")
    if options.size is None and options.duration is None and options.count is None:
        parser.error("You must specify --size, --duration or --count.")
    duration = None if options.duration is None else _seconds(parser, options.duration)
    if any(limit is not None and not 0 < limit < float("inf") for limit in (options.size, duration, options.count)):
        parser.error("--size, --duration and --count must be more than 0")
    stem, extension = os.path.splitext(args[0])
    if options.output_dir is not None:
        stem = os.path.join(options.output_dir, os.path.basename(stem))
    extension = extension or ".bag"
    if not options.force:  # they may be the recorder's own splits
        _refuse_parts(stem, extension)
    with BagReader(args[0]) as bag, interruptible("the files so far are whole"):
        choice = choice_of(options, bag)
        warn_of_strangers(choice, [bag])
        with Progress(args[0], content_size(bag)) as progress:
            paths = edit.split(
                choice.messages(bag),
                lambda number: f"{stem}_{number}{extension}",
                size=None if options.size is None else int(options.size * (1 << 20)),
                duration=None if duration is None else int(duration * NS),
                count=options.count,
                compression=options.compression,
                cipher=bag.file.cipher,
                repeat_latched=bool(options.repeat_latched),
                progress=progress,
            )
    if paths:
        print("\n".join(paths))
    else:
        print(f"{args[0]}: there are no such messages; nothing was written", file=sys.stderr)


def _refuse_parts(stem: str, extension: str) -> None:
    folder, name = os.path.split(stem)
    part = re.compile(re.escape(name) + r"_\d+" + re.escape(extension))
    there: list[str] = []
    with contextlib.suppress(OSError):  # of a folder that is not there the writer says so
        there = sorted(filter(part.fullmatch, os.listdir(folder or ".")))
    if there:
        raise CommandError(f"{os.path.join(folder, there[0])} already exists; --force replaces such files")


def _seconds(parser: OptionParser, text: str) -> float:
    units = {"s": 1, "m": 60, "h": 3600}
    try:
        return float(text[:-1]) * units[text[-1]] if text[-1:] in units else float(text)
    except ValueError:
        return parser.error(f"--duration: {text!r} is not a duration such as 30, 5m or 2h")


def rename_topic(invocation: Invocation) -> None:
    """``bag rename-topic IN OUT OLD NEW [OLD NEW ...]``."""
    parser = invocation.parser("rename-topic [options] INBAG OUTBAG OLD NEW [OLD NEW ...]")
    parser.description = "Rename topics. OLD/ and NEW/ with a slash at their ends rename all topics of a namespace."
    add_compression(parser, "none")
    options, args = parser.parse_args(invocation.args)
    if len(args) < 4 or len(args) % 2:
        parser.error("You must specify an in bag, an out bag, and pairs of an old and a new name.")
    source, target, *names = args
    different(source, target)
    pairs = dict(zip(names[::2], names[1::2], strict=True))
    for new in pairs.values():
        if not is_legal_name(new.rstrip("/")):
            raise CommandError(f"{new!r} is not a legal name of a topic")
    with BagReader(source) as bag:
        topics = {connection.topic for connection in bag.connections.values()}
        for old in pairs:
            if not any(_renamed(topic, {old: "?"}) != topic for topic in topics):
                raise CommandError(f"{source} has no topic {old}{did_you_mean(old, topics)}")
        with new_file(target) as part, Progress(target, content_size(bag)) as progress:
            count = edit.copy(
                bag.messages(),
                part,
                compression=options.compression,
                cipher=bag.file.cipher,
                rename=lambda topic: _renamed(topic, pairs),
                progress=progress,
            )
    print(f"{target}: {count} messages")


def _renamed(topic: str, pairs: Mapping[str, str]) -> str:
    for old, new in pairs.items():
        if topic.lstrip("/") == old.lstrip("/"):
            return new
        if old.endswith("/") and topic.lstrip("/").startswith(old.lstrip("/")):
            return new + topic.lstrip("/")[len(old.lstrip("/")) :]
    return topic


def retime(invocation: Invocation) -> None:
    """``bag retime [options] IN OUT``."""
    parser = invocation.parser("retime [options] INBAG OUTBAG")
    parser.description = "Move the times at which messages were recorded. What is in the messages stays as it is."
    parser.add_option("--offset", metavar="SEC", help="add SEC seconds")
    parser.add_option("--start", metavar="TIME", help="let the bag begin at TIME, as --from of `filter` has it")
    parser.add_option("--rate", type="float", default=1.0, metavar="F", help="bring messages F times closer together")
    parser.add_option("--header-stamp", action="store_true", help="take the stamps of messages with a header")
    add_compression(parser, "none")
    options, args = parser.parse_args(invocation.args)
    if len(args) != 2:
        parser.error("You must specify an in bag and an out bag.")
    if options.offset is not None and options.start is not None:
        parser.error("You can only specify one of --offset and --start.")
    if options.header_stamp and (options.offset or options.start or options.rate != 1.0):
        parser.error("--header-stamp does not go with the other options")
    if not options.header_stamp and options.offset is None and options.start is None and options.rate == 1.0:
        parser.error("You must specify --offset, --start, --rate or --header-stamp.")
    if not 0 < options.rate < float("inf"):
        parser.error("--rate must be more than 0")
    source, target = args
    different(source, target)
    with Bag(source, unindexed=False) as bag:
        if options.header_stamp:
            change = _stamp_of(bag)
        else:
            offset = parse_time(options.offset, None, "--offset") if options.offset is not None else 0
            if options.start is not None:
                offset = parse_time(options.start, bag.reader, "--start") - bag.reader.start
            change = edit.shifted(offset, options.rate, bag.reader.start)
        with new_file(target) as part, Progress(target, content_size(bag.reader)) as progress:
            count = edit.copy(
                bag.reader.messages(),
                part,
                compression=options.compression,
                cipher=bag.reader.file.cipher,
                retime=change,
                progress=progress,
            )
    print(f"{target}: {count} messages")


def _stamp_of(bag: Bag) -> Callable[[RawMessage], int]:
    def stamp(stored: RawMessage) -> int:
        header = getattr(bag.decode(stored), "header", None)
        found = getattr(header, "stamp", None)
        return found.to_nsec() if isinstance(found, Time) and found else stored.time

    return stamp
