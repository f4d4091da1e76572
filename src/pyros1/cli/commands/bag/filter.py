"""``bag filter``: copies the messages that match an expression or options to another bag (L141)."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator
from typing import Any

from pyros1.bag.api import Bag
from pyros1.bag.edit import editing as edit
from pyros1.bag.format.reader import RawMessage
from pyros1.bag.format.records import RECORD_OVERHEAD
from pyros1.cli.commands.bag._options import SELECTION_OPTIONS, has_selection, make_selection, warn_about_unknown_topics
from pyros1.cli.commands.bag._writing.files import check_different, new_file
from pyros1.cli.failures import CommandError, UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Option, Verb
from pyros1.cli.shared.filters import filter_expression
from pyros1.cli.shared.options import CHUNK_LIMIT_OPTION
from pyros1.cli.shared.progress import Progress
from pyros1.ground.expressions import LimitError, UnknownNameError
from pyros1.ground.timing import Time
from pyros1.observe.expression import ExpressionError

_USAGE = """[options] INBAG OUTBAG [EXPRESSION]

EXPRESSION is a Python expression. Only a safe subset of Python is allowed.

The following variables are available:
 * topic: name of topic
 * m: message
 * t: time of message (t.secs, t.nsecs, t.to_sec())"""


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Write the messages of a bag that match the expression and the options to another bag."""
    source, target, text = _parse_arguments(options, args)
    if not os.path.isfile(source):
        raise CommandError(f"Cannot locate input bag file [{source}]", 2, plain=True)
    check_different(source, target, 3)
    expression = None if text is None else _MessageExpression(text)
    print_expression = None if options.print_expression is None else _MessageExpression(options.print_expression)
    with Bag(source, unindexed=False) as bag, new_file(target) as temporary_path:
        total_count = len(bag)
        size = bag.reader.content_size()
        selection = make_selection(options, bag.reader)
        warn_about_unknown_topics(selection, [bag.reader])
        with Progress(target, size) as progress:
            messages = _matching_messages(selection.messages(bag.reader), bag, expression, print_expression, progress)
            count = edit.copy(messages, temporary_path, cipher=bag.reader.file.cipher)
    print(f"{target}: {count} of {total_count} messages")


VERB = Verb(
    "filter",
    "select messages by expression, topic or time",
    CHUNK_LIMIT_OPTION,
    Option(
        "-p",
        "--print",
        dest="print_expression",
        metavar="PRINT-EXPRESSION",
        help="Python expression to print for verbose debugging. Uses same variables as filter-expression",
    ),
    *SELECTION_OPTIONS,
    Argument("INBAG", "bag"),
    Argument("OUTBAG", "file"),
    Argument("EXPRESSION", optional=True),
    usage=_USAGE,
    description="Filter the contents of the bag.",
    examples=[
        (
            "run.bag out.bag \"topic == '/odom' and m.twist.twist.linear.x > 1\"",
            "keep the messages that match an expression",
        ),
        (
            "run.bag out.bag --topics '/camera/*,/tf' --from 10 --to -5",
            "keep some topics, from 10 s after the start to 5 s before the end",
        ),
    ],
    run=run,
)


def _parse_arguments(options: Any, args: list[str]) -> tuple[str, str, str | None]:
    if not args:
        raise UsageError("You must specify an in bag, an out bag, and an expression.")
    if len(args) == 1:
        raise UsageError("You must specify an out bag and an expression.")
    if len(args) == 2 and not has_selection(options):
        raise UsageError("You must specify an expression.")
    if len(args) > 3:
        raise UsageError("Too many arguments.")
    return args[0], args[1], args[2] if len(args) == 3 else None


class _MessageExpression:
    """An expression about a recorded message, with the variables topic, m and t.

    Args:
        text: The expression.

    Raises:
        ExpressionError: The expression is malformed or uses something that is not allowed.
    """

    def __init__(self, text: str) -> None:
        self._expression = filter_expression(text)
        self._needs_message = re.search(r"\bm\b", text) is not None

    def __call__(self, bag: Bag, raw_message: RawMessage) -> Any:
        """Return the expression's value for a message. The message is decoded only if the expression uses ``m``.

        Raises:
            CommandError: The expression cannot be evaluated.
        """
        names = {"topic": raw_message.connection.topic, "t": Time.from_nsec(raw_message.time)}
        try:
            return self._expression({**names, "m": bag.decode(raw_message) if self._needs_message else None})
        except ExpressionError as error:
            message_description = (
                f"{raw_message.connection.topic} at {raw_message.time / 1e9:.6f} ({raw_message.connection.type})"
            )
            has_hint = isinstance(error, UnknownNameError | LimitError)
            hint = "" if has_hint else ": does `topic == ... and` need to come first?"
            raise CommandError(f"{error} (in the message on {message_description}){hint}") from None


def _matching_messages(
    messages: Iterator[RawMessage],
    bag: Bag,
    expression: _MessageExpression | None,
    print_expression: _MessageExpression | None,
    progress: Callable[[int], object],
) -> Iterator[RawMessage]:
    processed_bytes = 0
    for raw_message in messages:
        matches = expression is None or expression(bag, raw_message)
        if print_expression is not None:
            print("MATCH" if matches else "NO MATCH", print_expression(bag, raw_message))
        if matches:
            yield raw_message
        processed_bytes += len(raw_message.data) + RECORD_OVERHEAD
        progress(processed_bytes)
