"""``bag reindex``: repairs bags that were not closed or are damaged (L143)."""

from __future__ import annotations

import os
import sys
from typing import Any

from pyros1.bag.edit.reindex import ReindexResult, reindex
from pyros1.bag.errors import BagError
from pyros1.cli.commands.bag._writing.rewrite import BAGS_ARGUMENT, REWRITE_OPTIONS, REWRITE_USAGE, rewrite_each
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Verb
from pyros1.cli.shared.progress import Progress

_MAX_ERRORS_SHOWN = 5


def run(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Rewrite bags, keeping all messages that can be read. Return the exit code."""

    def reindex_bag(source: str, target: str) -> None:
        with Progress(source, os.path.getsize(source), quiet=options.quiet) as progress:
            result = reindex(source, target, progress)
        if not result.messages:
            raise BagError(source, f"{_no_messages_text(result)}; the file was not changed")
        if options.quiet:
            return
        for damage in result.damaged_places[:_MAX_ERRORS_SHOWN]:
            print(f"{source}: at byte {damage.offset}: {damage.reason}", file=sys.stderr)
        if len(result.damaged_places) > _MAX_ERRORS_SHOWN:
            print(f"{source}: {len(result.damaged_places) - _MAX_ERRORS_SHOWN} more damaged places", file=sys.stderr)
        lost = f"; {result.lost} are lost because they have no connection record or valid time" if result.lost else ""
        print(f"{source}: {result.messages} messages{lost}")

    return rewrite_each(options, args, reindex_bag)


VERB = Verb(
    "reindex",
    "repair bags that were not closed or are damaged",
    *REWRITE_OPTIONS,
    BAGS_ARGUMENT,
    usage=REWRITE_USAGE,
    description="Reindexes one or more bag files, and recovers the readable messages of damaged ones.",
    examples=[("run.bag.active", "repair a bag that was not closed")],
    run=run,
)


def _no_messages_text(result: ReindexResult) -> str:
    if result.lost:
        return f"the {result.lost} messages found in it have no connection record or no valid time"
    reasons = "".join(f"; at byte {damage.offset}: {damage.reason}" for damage in result.damaged_places[:1])
    return f"no messages were found in it{reasons}"
