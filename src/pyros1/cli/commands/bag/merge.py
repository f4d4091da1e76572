"""``bag merge``: copies the messages of several bags to one, in chronological order."""

from __future__ import annotations

import contextlib
import sys
from typing import Any

from pyros1.bag.edit import editing as edit
from pyros1.bag.format.reader import BagReader
from pyros1.cli.commands.bag._options import (
    SELECTION_OPTIONS,
    compression_options,
    make_selection,
    warn_about_unknown_topics,
)
from pyros1.cli.commands.bag._writing.files import check_different, new_file
from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Verb
from pyros1.cli.shared.options import CHUNK_LIMIT_OPTION
from pyros1.cli.shared.progress import Progress


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Write the messages of several bags to one bag."""
    if len(args) < 2:
        raise UsageError("You must specify an out bag and at least one in bag.")
    target, *sources = args
    for source in sources:
        check_different(source, target)
    with contextlib.ExitStack() as stack:
        bags = [stack.enter_context(BagReader(source)) for source in sources]
        first_bag = min(bags, key=lambda bag: bag.start or sys.maxsize)
        selection = make_selection(options, first_bag)
        warn_about_unknown_topics(selection, bags)
        progress = stack.enter_context(Progress(target, sum(bag.content_size() for bag in bags)))
        temporary_path = stack.enter_context(new_file(target))
        messages = edit.merge(bags, selection)
        cipher = next((bag.file.cipher for bag in bags if bag.file.cipher is not None), None)
        count = edit.copy(messages, temporary_path, compression=options.compression, cipher=cipher, progress=progress)
    print(f"{target}: {count} messages")


VERB = Verb(
    "merge",
    "merge several bags into one",
    CHUNK_LIMIT_OPTION,
    *SELECTION_OPTIONS,
    *compression_options("none"),
    Argument("OUTBAG", "bag"),
    Argument("INBAG", "bag", repeatable=True),
    usage="[options] OUTBAG INBAG1 [INBAG2 ...]",
    description="Merge bags into one, in chronological order.",
    examples=[("all.bag a.bag b.bag", "merge two bags in chronological order")],
    stock="",
    run=run,
)
