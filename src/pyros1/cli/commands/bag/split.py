"""``bag split``: distributes the messages of a bag among several bags."""

from __future__ import annotations

import contextlib
import os
import re
import sys
from typing import Any

from pyros1.bag.edit import editing as edit
from pyros1.bag.format.reader import BagReader
from pyros1.bag.format.records import NS_PER_S
from pyros1.cli.commands.bag._options import (
    SELECTION_OPTIONS,
    compression_options,
    make_selection,
    warn_about_unknown_topics,
)
from pyros1.cli.commands.bag._writing.files import clean_up_on_signal
from pyros1.cli.failures import CommandError, UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Flag, Option, Verb
from pyros1.cli.shared.options import CHUNK_LIMIT_OPTION
from pyros1.cli.shared.progress import Progress

_DURATION_UNITS = {"s": 1, "m": 60, "h": 3600}


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Write the messages of a bag to several bags of limited size, duration or message count."""
    if len(args) != 1:
        raise UsageError("You must specify one bag.")
    if options.size is None and options.duration is None and options.count is None:
        raise UsageError("You must specify --size, --duration or --count.")
    duration = None if options.duration is None else _parse_duration(options.duration)
    if any(limit is not None and not 0 < limit < float("inf") for limit in (options.size, duration, options.count)):
        raise UsageError("--size, --duration and --count must be greater than 0")
    stem, extension = os.path.splitext(args[0])
    if options.output_dir is not None:
        stem = os.path.join(options.output_dir, os.path.basename(stem))
    extension = extension or ".bag"
    if not options.force:  # existing files with such names may be recordings, since `bag record` uses these names
        _check_no_parts_exist(stem, extension)
    with BagReader(args[0]) as bag, clean_up_on_signal("the files written so far are complete"):
        selection = make_selection(options, bag)
        warn_about_unknown_topics(selection, [bag])
        with Progress(args[0], bag.content_size()) as progress:
            paths = edit.split(
                selection.messages(bag),
                lambda number: f"{stem}_{number}{extension}",
                size=None if options.size is None else int(options.size * (1 << 20)),
                duration=None if duration is None else int(duration * NS_PER_S),
                count=options.count,
                compression=options.compression,
                cipher=bag.file.cipher,
                repeat_latched=bool(options.repeat_latched),
                progress=progress,
            )
    if paths:
        print("\n".join(paths))
    else:
        print(f"{args[0]}: no messages are selected; nothing was written", file=sys.stderr)


VERB = Verb(
    "split",
    "split a bag into several",
    CHUNK_LIMIT_OPTION,
    Option("--size", type="float", metavar="MB", help="start a new file after MB mebibytes"),
    Option("--duration", metavar="SEC", help="start a new file after SEC seconds; for minutes or hours: 5m, 2h"),
    Option("--count", type="int", metavar="N", help="start a new file after N messages"),
    Flag("--repeat-latched", help="start every file with the latched messages recorded before it"),
    Option("--output-dir", metavar="DIR", help="write to directory DIR"),
    Flag("-f", "--force", help="replace existing files"),
    *SELECTION_OPTIONS,
    *compression_options("none"),
    Argument("INBAG", "bag"),
    description="Split a bag into NAME_0.bag, NAME_1.bag, ... whenever a given limit is reached.",
    examples=[("run.bag --duration 5m --repeat-latched", "write run_0.bag, run_1.bag, ...")],
    stock="",
    run=run,
)


def _check_no_parts_exist(stem: str, extension: str) -> None:
    folder, name = os.path.split(stem)
    pattern = re.compile(re.escape(name) + r"_\d+" + re.escape(extension))
    existing_names: list[str] = []
    with contextlib.suppress(OSError):  # the writer reports a missing folder
        existing_names = sorted(filter(pattern.fullmatch, os.listdir(folder or ".")))
    if existing_names:
        raise CommandError(f"{os.path.join(folder, existing_names[0])} already exists: use --force to replace it")


def _parse_duration(text: str) -> float:
    try:
        return float(text[:-1]) * _DURATION_UNITS[text[-1]] if text[-1:] in _DURATION_UNITS else float(text)
    except ValueError:
        raise UsageError(f"--duration: {text!r} is not a duration such as 30, 5m or 2h") from None
