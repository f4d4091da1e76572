"""``topic echo``: prints messages or their fields (L60-L63)."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable
from typing import Any

from pyros1.cli.clean_output import data_stream
from pyros1.cli.failures import CommandError, UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Flag, Option, Verb
from pyros1.cli.shared.filters import ExpressionClock, filter_expression
from pyros1.cli.shared.options import CHUNK_LIMIT_OPTION
from pyros1.cli.shared.output_formats import JsonFormat, PlotFormat, TextFormat, ValueWriter
from pyros1.cli.shared.subscribing import subscribe, wait_for_topic
from pyros1.ground.errors import DeserializationError, MessageError
from pyros1.ground.terminal_text import one_line
from pyros1.ground.timing import Time
from pyros1.msgs import AnyMsg, Message
from pyros1.observe.decoder import Decoder
from pyros1.observe.expression import Expression, ExpressionError
from pyros1.observe.fields import FieldPath, FieldPathError

_CLOCK_TIMEOUT = 2.0
_MIN_WIDTH = 2
_MAX_WARNINGS = 100


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the messages of a topic or one of their fields."""
    _check_options(options, args)
    name = invocation.resolve(args[0]) if args else ""
    clock = ExpressionClock()
    expression = filter_expression(options.filter_expr, clock) if options.filter_expr else None
    if options.bag:
        _echo_bag(invocation, options, name, expression)
        return
    with invocation.open_node() as node:
        clock.node = node
        topic_match = wait_for_topic(invocation, node, name)
        if topic_match is None:
            return
        topic, path, type_name = topic_match
        print_value = _make_writer(options, node.now)
        printer = MessagePrinter(topic, FieldPath(path), print_value, expression, options.msg_count, type_name)
        with subscribe(node, topic, printer.on_message):
            _wait_until_done(invocation, node, printer)
    if printer.error is not None:
        raise printer.error


VERB = Verb(
    "echo",
    "print messages to screen",
    Option("-b", "--bag", metavar="BAGFILE", help="echo messages from .bag file"),
    CHUNK_LIMIT_OPTION,
    Flag("-p", dest="plot", help="echo in a plotting friendly format"),
    Option("-w", dest="width", metavar="NUM_WIDTH", help="fixed width for numeric values"),
    Option(
        "--filter",
        dest="filter_expr",
        metavar="FILTER-EXPRESSION",
        help="Python expression to filter messages that are printed. It can use m (the message), topic (the topic "
        "name) and harmless functions such as len, abs, min and max.",
    ),
    Flag("--nostr", help="exclude string fields"),
    Flag("--noarr", help="exclude arrays"),
    Flag("-c", "--clear", help="clear screen before printing next message"),
    Flag("-a", "--all", help="display all messages in bag, only valid with -b option"),
    Option("-n", dest="msg_count", metavar="COUNT", help="number of messages to echo"),
    Flag("--offset", help="display time as offsets from current time (in seconds)"),
    Flag("--json", help="print each message as one line of JSON, which `topic pub` reads", pyros1_only=True),
    Argument("/topic", "topic"),
    usage="[options] /topic",
    examples=[
        ("/pose", "print all messages"),
        ("-n 1 /pose/pose/position", "print a field of one message"),
        ("-p /odom > odom.csv", "print CSV for a spreadsheet"),
        ("--filter 'm.ranges[0] < 1' /scan", "print only messages that match an expression"),
        ("--json /odom > odom.jsonl", "print lines that `topic pub -f` can publish"),
    ],
    run=run,
)


def _echo_bag(invocation: Invocation, options: Any, name: str, expression: Expression | None) -> None:
    from pyros1.cli.commands.topic import _bag  # noqa: PLC0415 - slow to import

    path = ""
    topics = None
    if not options.all:
        topic_match = _bag.find_topic(options.bag, name, invocation.resolve)
        if topic_match is None:
            return
        topics, path = topic_match
    message_time = Time()
    print_value = _make_writer(options, lambda: message_time)
    printers: dict[str, MessagePrinter] = {}
    remaining_count = options.msg_count

    def on_message(topic: str, raw: AnyMsg, time: Time) -> bool:
        nonlocal message_time, remaining_count
        message_time = time
        if remaining_count is not None and remaining_count <= 0:
            return False
        printer = printers.get(topic)
        if printer is None:
            full_name = invocation.resolve(topic)
            printer = printers[topic] = MessagePrinter(full_name, FieldPath(path), print_value, expression, None)
        count_before = printer.count
        printer.on_message(raw)
        if isinstance(printer.error, CommandError):
            raise CommandError(f"{options.bag}: at {time.to_sec():.6f}: {printer.error}") from printer.error
        if printer.error is not None:
            raise printer.error
        if remaining_count is not None:
            remaining_count -= printer.count - count_before
        return remaining_count is None or remaining_count > 0

    _bag.for_each_message(options.bag, topics, on_message)


def _make_writer(options: Any, now: Callable[[], Time]) -> ValueWriter:
    if options.json:
        return JsonFormat(options)
    return PlotFormat(options, now) if options.plot else TextFormat(options, now)


def _check_options(options: Any, args: list[str]) -> None:
    if options.all and not options.bag:
        raise UsageError("Display all option is only valid when echoing from bag files")
    if options.offset and options.bag:
        raise UsageError("offset time option is not valid with bag files")
    if not args and not options.all:
        raise UsageError("topic must be specified")
    if len(args) > 1:
        raise UsageError("you may only specify one input topic")
    for field, name in (("msg_count", "COUNT"), ("width", "NUM_WIDTH")):
        value = getattr(options, field)
        if value is not None:
            try:
                setattr(options, field, int(value))
            except ValueError:
                raise UsageError(f"{name} must be an integer") from None
    if options.width is not None and options.width < _MIN_WIDTH:
        raise UsageError(f"Fixed width for numeric values must be at least {_MIN_WIDTH}")


def _wait_until_done(invocation: Invocation, node: Any, printer: MessagePrinter) -> None:
    """Wait until the count is reached or the node shuts down. Warn once if simulated time has not started (L63)."""
    has_warned = False
    waited_seconds = 0.0
    while node.ok() and not printer.done.wait(0.25):
        waited_seconds += 0.25
        if waited_seconds >= _CLOCK_TIMEOUT and not has_warned and not printer.count and node.now().is_zero():
            has_warned = True
            print(
                "WARNING: no messages received and simulated time is active.\nIs /clock being published?",
                file=sys.stderr,
                flush=True,
            )


class MessagePrinter:
    """Prints messages that pass the filter until the count is reached.

    Attributes:
        count: the number of messages printed.
        done: set when the count is reached or an error occurred.
        error: the error that stopped the output; None if there was none.
    """

    def __init__(
        self,
        topic: str,
        path: FieldPath,
        print_value: ValueWriter,
        expression: Expression | None,
        max_count: int | None,
        type_name: str | None = None,
    ) -> None:
        self.count = 0
        self.done = threading.Event()
        self.error: Exception | None = None
        self._topic = topic
        self._path = path
        self._print_value = print_value
        self._expression = expression
        self._max_count = max_count
        self._decoder = Decoder(type_name or "", prefer_installed=type_name is not None)
        self._skips_invalid_messages = type_name is not None
        self._printed_warnings: set[str] = set()
        self._out = data_stream()  # messages are already escaped, and --clear also works for files, as in stock ROS

    def on_message(self, raw: AnyMsg) -> None:
        """Print a message if it passes the filter. Called in the subscription's thread."""
        if self.done.is_set():
            return
        if self._max_count is not None and self.count >= self._max_count:
            self.done.set()
            return
        try:
            output = self._value_to_print(raw)
            if output is None:
                return
            self._print_value(*output, self._out.write)
            del output
            self._out.flush()
        except (OSError, CommandError) as error:
            self.error = error
            self.done.set()
            return
        self.count += 1
        if self._max_count is not None and self.count >= self._max_count:
            self.done.set()

    def _value_to_print(self, raw: AnyMsg) -> tuple[Message, Any, str | None] | None:
        """Return the message, the value and its type; None if nothing is to be printed."""
        try:
            message = self._decoder.decode(raw)
        except MessageError as error:
            # The messages of other publishers may be valid.
            if self._skips_invalid_messages and isinstance(error, DeserializationError):
                self._warn(f"a message on {self._topic} cannot be printed: {error}")
                return None
            type_name = (raw._connection_header or {}).get("type", "unknown type")
            raise CommandError(
                f"a message of type [{one_line(type_name)}] on {self._topic} cannot be printed: {error}"
            ) from None
        try:
            if self._expression is not None and not self._expression({"m": message, "topic": self._topic}):
                return None
            value, value_type = self._path.get(message)
        except (ExpressionError, FieldPathError) as error:
            self._warn(str(error))  # only this message may be affected, for example if its array is too short
            return None
        return message, value, value_type

    def _warn(self, text: str) -> None:
        """Print a warning once."""
        if text not in self._printed_warnings and len(self._printed_warnings) < _MAX_WARNINGS:
            self._printed_warnings.add(text)
            print(text, file=sys.stderr, flush=True)
