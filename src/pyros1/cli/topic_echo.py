"""``topic echo`` (L60-L63)."""

from __future__ import annotations

import re
import sys
import threading
from collections.abc import Callable
from optparse import Values
from typing import Any

from pyros1.cli.clean_output import data_stream
from pyros1.cli.common import CommandError, Invocation, use_colour
from pyros1.cli.expression import Expression, ExpressionError
from pyros1.cli.fields import FieldPath, FieldPathError
from pyros1.cli.subscribing import Decoder, find_topic, subscribe
from pyros1.errors import MessageError
from pyros1.msgs import AnyMsg, Message
from pyros1.msgs.text import format_message
from pyros1.shown import json_text, lines, one_line
from pyros1.timing import Time, TVal

_CLEAR = "\033[2J\033[;H"
_CLOCK_PATIENCE = 2.0
_LEAST_WIDTH = 2
_NAME = re.compile(r"^( *(?:- )?)([A-Za-z]\w*):(?=$| )", re.M)
"""The name of a field at the beginning of a line."""


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
        if printer.error is not None:
            raise printer.error
        if left is not None:
            left -= printer.count - before
        return left is None or left > 0

    topic_bag.replay(options.bag, topics, take)


def _show(options: Values, now: Callable[[], Time]) -> Callable[[Message, Any, str | None], str]:
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
        show: Callable[[Message, Any, str | None], str],
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
            text = self._text(raw)
            if text is None:
                return
            self._out.write(text)
            self._out.flush()
        except (OSError, CommandError) as error:
            self.error = error
            self.done.set()
            return
        self.count += 1
        if self._limit is not None and self.count >= self._limit:
            self.done.set()

    def _text(self, raw: AnyMsg) -> str | None:
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
        return self._show(message, value, kind)


class Text:
    """Messages as YAML-like text, with ``---`` behind each (L61)."""

    def __init__(self, options: Values, now: Callable[[], Time]) -> None:
        self._prefix = _CLEAR if options.clear else ""
        self._colour = use_colour(sys.stdout)
        self._now = now if options.offset else None
        self._settings: dict[str, Any] = {
            "no_string": bool(options.nostr),
            "no_array": bool(options.noarr),
            "width": options.width,
        }

    def __call__(self, message: Message, value: Any, kind: str | None) -> str:
        offset = self._now() if self._now else None
        text = lines(format_message(value, type_name=kind, time_offset=offset, **self._settings))
        if self._colour:
            text = _NAME.sub("\\1\033[36m\\2\033[0m:", text)
        return f"{self._prefix}{text}\n---\n"


class Json:
    """Messages as lines of JSON."""

    def __init__(self, options: Values) -> None:
        self._nostr, self._noarr = bool(options.nostr), bool(options.noarr)

    def __call__(self, message: Message, value: Any, kind: str | None) -> str:
        import json  # noqa: PLC0415

        from pyros1.msgs.json_form import to_json  # noqa: PLC0415

        tree = to_json(value, kind)
        if self._nostr or self._noarr:
            tree = _without(value, tree, self._nostr, self._noarr)
        return json_text(json.dumps(tree, ensure_ascii=False)) + "\n"


def _without(value: Any, tree: Any, nostr: bool, noarr: bool) -> Any:
    """A message's JSON without strings or arrays."""
    if isinstance(value, (list, tuple)) and isinstance(tree, list):
        return [_without(item, part, nostr, noarr) for item, part in zip(value, tree, strict=True)]
    if not isinstance(value, Message):
        return tree
    return {
        name: _without(getattr(value, name), tree[name], nostr, noarr)
        for name, kind in zip(value.__slots__, value._slot_types, strict=True)
        if not (noarr and "[" in kind) and not (nostr and kind.partition("[")[0] == "string")
    }


class Plot:
    """Messages as rows of comma-separated values, under a row of names (L62)."""

    def __init__(self, options: Values, now: Callable[[], Time]) -> None:
        self._now = now
        self._offset = bool(options.offset)
        self._recorded = bool(options.bag)  # then the time of recording counts
        self._nostr, self._noarr = bool(options.nostr), bool(options.noarr)
        self._header_done = False

    def __call__(self, message: Message, value: Any, kind: str | None) -> str:
        now = self._now()
        whole = not self._recorded and kind is None and getattr(message, "_has_header", False)
        stamp = message.header.stamp if whole else now  # type: ignore[attr-defined] # _has_header says that it is there
        ns = stamp.to_nsec() - (now.to_nsec() if self._offset and whole else 0)
        row: list[str] = []
        self._values(value, kind, now if self._offset else None, row)
        text = lines(f"{ns},{','.join(row)}\n")
        if not self._header_done:
            self._header_done = True
            names: list[str] = []
            self._names(value, kind, "field", names)
            text = f"%time,{','.join(names)}\n{text}"
        return text

    def _shown(self, kind: str) -> bool:
        return not (self._noarr and "[" in kind) and not (self._nostr and kind.partition("[")[0] == "string")

    def _slots(self, message: Message) -> list[tuple[str, str]]:
        shown = [(n, t) for n, t in zip(message.__slots__, message._slot_types, strict=True) if self._shown(t)]
        return [(n, t) for n, t in shown if not isinstance(getattr(message, n), bytes)]  # as stock: no raw data in rows

    def _names(self, value: Any, kind: str | None, prefix: str, names: list[str]) -> None:
        if isinstance(value, Message):
            for name, slot_type in self._slots(value):
                self._names(getattr(value, name), slot_type, f"{prefix}.{name}", names)
        elif isinstance(value, (list, tuple, bytes)):
            for number, element in enumerate(value):
                self._names(element, None, f"{prefix}{number}", names)
        else:
            names.append(prefix)

    def _values(self, value: Any, kind: str | None, offset: Time | None, row: list[str]) -> None:
        if isinstance(value, Message):
            for name, slot_type in self._slots(value):
                self._values(getattr(value, name), slot_type, offset, row)
        elif isinstance(value, (list, tuple, bytes)):
            for element in value:
                self._values(element, None, offset, row)
        elif isinstance(value, TVal):
            minus = offset.to_nsec() if offset is not None and isinstance(value, Time) else 0
            row.append(str(value.to_nsec() - minus))
        else:
            row.append(str(int(value) if isinstance(value, bool) else value))
