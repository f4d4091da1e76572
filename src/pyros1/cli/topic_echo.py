"""``topic echo`` (L60-L63)."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable
from optparse import Values
from typing import Any

from pyros1.cli.clean_output import data_stream
from pyros1.cli.common import CommandError, Invocation
from pyros1.cli.expression import Expression, ExpressionError
from pyros1.cli.fields import FieldPath, FieldPathError
from pyros1.cli.subscribing import Decoder, find_topic, subscribe
from pyros1.cli.topic_forms import Json, Plot, Show, Text
from pyros1.errors import MessageError
from pyros1.msgs import AnyMsg, Message
from pyros1.shown import one_line
from pyros1.timing import Time

_CLOCK_PATIENCE = 2.0
_LEAST_WIDTH = 2


def echo(invocation: Invocation) -> None:
    """``topic echo [options] /topic[/field...]``."""
    options, name = _arguments(invocation)
    expression = Expression(options.filter_expr) if options.filter_expr else None
    if options.bag:
        _echo_bag(options, name, expression)
        return
    with invocation.open_node() as node:
        found = find_topic(invocation, node, name)
        if found is None:
            return
        topic, path = found
        show = _show(options, node.now)
        printer = Printer(topic, FieldPath(path), show, expression, options.msg_count)
        with subscribe(node, topic, printer.arrived):
            _wait(invocation, node, printer)
    if printer.error is not None:
        raise printer.error


def _echo_bag(options: Values, name: str, expression: Expression | None) -> None:
    from pyros1.cli import topic_bag  # noqa: PLC0415 - bags are not cheap

    path = ""
    topics = None
    if not options.all:
        found = topic_bag.split_name(options.bag, name)
        if found is None:
            return
        topics, path = [found[0]], found[1]
    moment = Time()
    show = _show(options, lambda: moment)
    printers: dict[str, Printer] = {}
    left = options.msg_count

    def take(topic: str, raw: AnyMsg, when: Time) -> bool:
        nonlocal moment, left
        moment = when
        if left is not None and left <= 0:
            return False
        printer = printers.get(topic)
        if printer is None:
            printer = printers[topic] = Printer(topic, FieldPath(path), show, expression, None)
        before = printer.count
        printer.arrived(raw)
        if isinstance(printer.error, CommandError):
            raise CommandError(f"{options.bag}: at {when.to_sec():.6f}: {printer.error}") from printer.error
        if printer.error is not None:
            raise printer.error
        if left is not None:
            left -= printer.count - before
        return left is None or left > 0

    topic_bag.replay(options.bag, topics, take)


def _show(options: Values, now: Callable[[], Time]) -> Show:
    if options.json:
        return Json(options)
    return Plot(options, now) if options.plot else Text(options, now)


def _arguments(invocation: Invocation) -> tuple[Values, str]:
    parser = invocation.parser("echo [options] /topic")
    parser.add_option("-b", "--bag", dest="bag", metavar="BAGFILE", help="echo messages from .bag file")
    invocation.add_chunk_limit(parser)
    parser.add_option("-p", dest="plot", action="store_true", help="echo in a plotting friendly format")
    parser.add_option("-w", dest="width", metavar="NUM_WIDTH", help="fixed width for numeric values")
    parser.add_option(
        "--filter",
        dest="filter_expr",
        metavar="FILTER-EXPRESSION",
        help="Python expression to filter messages that are printed. It can use m (the message), topic (the topic "
        "name) and harmless functions such as len, abs, min and max.",
    )
    parser.add_option("--nostr", dest="nostr", action="store_true", help="exclude string fields")
    parser.add_option("--noarr", dest="noarr", action="store_true", help="exclude arrays")
    parser.add_option("-c", "--clear", action="store_true", help="clear screen before printing next message")
    parser.add_option(
        "-a", "--all", dest="all", action="store_true", help="display all messages in bag, only valid with -b option"
    )
    parser.add_option("-n", dest="msg_count", metavar="COUNT", help="number of messages to echo")
    parser.add_option("--offset", action="store_true", help="display time as offsets from current time (in seconds)")
    invocation.add_json(parser, "print each message as one line of JSON, which `topic pub` reads")
    options, args = parser.parse_args(invocation.args)
    if options.all and not options.bag:
        parser.error("Display all option is only valid when echoing from bag files")
    if options.offset and options.bag:
        parser.error("offset time option is not valid with bag files")
    if not args and not options.all:
        parser.error("topic must be specified")
    if len(args) > 1:
        parser.error("you may only specify one input topic")
    for field, what in (("msg_count", "COUNT"), ("width", "NUM_WIDTH")):
        value = getattr(options, field)
        if value is not None:
            try:
                setattr(options, field, int(value))
            except ValueError:
                parser.error(f"{what} must be an integer")
    if options.width is not None and options.width < _LEAST_WIDTH:
        parser.error(f"Fixed width for numeric values must be at least {_LEAST_WIDTH}")
    return options, invocation.resolve(args[0]) if args else ""


def _wait(invocation: Invocation, node: Any, printer: Printer) -> None:
    """Until the count is reached or the node ends; warns once if simulated time does not run (L63)."""
    warned = False
    waited = 0.0
    while node.ok() and not printer.done.wait(0.25):
        waited += 0.25
        if waited >= _CLOCK_PATIENCE and not warned and not printer.count and node.now().is_zero():
            warned = True
            print(
                "WARNING: no messages received and simulated time is active.\nIs /clock being published?",
                file=sys.stderr,
                flush=True,
            )


class Printer:
    """Shows the messages that pass the filter, until there were enough.

    Attributes:
        count: messages shown.
        done: set when no more are wanted.
        error: what ended it before its time.
    """

    def __init__(
        self,
        topic: str,
        path: FieldPath,
        show: Show,
        expression: Expression | None,
        limit: int | None,
    ) -> None:
        self.count = 0
        self.done = threading.Event()
        self.error: Exception | None = None
        self._topic = topic
        self._path = path
        self._show = show
        self._expression = expression
        self._limit = limit
        self._decoder = Decoder()
        self._said: set[str] = set()
        self._out = data_stream()  # what comes from messages is clean, and --clear is meant, for a file too, as stock's

    def arrived(self, raw: AnyMsg) -> None:
        """Take one message; called from the subscription's thread."""
        if self.done.is_set():
            return
        if self._limit is not None and self.count >= self._limit:
            self.done.set()
            return
        try:
            shown = self._shown(raw)
            if shown is None:
                return
            self._show(*shown, self._out.write)
            del shown
            self._out.flush()
        except (OSError, CommandError) as error:
            self.error = error
            self.done.set()
            return
        self.count += 1
        if self._limit is not None and self.count >= self._limit:
            self.done.set()

    def _shown(self, raw: AnyMsg) -> tuple[Message, Any, str | None] | None:
        """Message, value and its type; None if it is not to be shown."""
        try:
            message = self._decoder.decode(raw)
        except MessageError as error:
            type_name = (raw._connection_header or {}).get("type", "unknown type")
            raise CommandError(
                f"a message of type [{one_line(type_name)}] on {self._topic} cannot be shown: {error}"
            ) from None
        try:
            if self._expression is not None and not self._expression({"m": message, "topic": self._topic}):
                return None
            value, kind = self._path.get(message)
        except (ExpressionError, FieldPathError) as error:
            # It may be this message's fault only: an array too short, say. Once said, it is known.
            if str(error) not in self._said:
                self._said.add(str(error))
                print(error, file=sys.stderr, flush=True)
            return None
        return message, value, kind
