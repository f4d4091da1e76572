"""``topic pub`` (L67-L69)."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator
from itertools import chain, islice
from time import time
from typing import Any

from pyros1.cli.failures import CommandError, UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.parsing import guard, parse_guarded, unguard
from pyros1.cli.records import Argument, Flag, Option, Verb
from pyros1.cli.shared.argument_names import argument_names
from pyros1.cli.shared.documents import Record, documents
from pyros1.ground.errors import DefinitionError, Error, MessageError, SerializationError, UnknownTypeError
from pyros1.ground.timing import Time
from pyros1.msgs import Message, load_message
from pyros1.msgs.fill import fill_message
from pyros1.values import load_yaml

HOLD_SECONDS = 3.0
"""Seconds that -1 keeps running, so that subscribers can receive the message."""

_SUBSCRIBER_TIMEOUT = 5.0
"""Seconds that messages from a file or stdin wait for the first subscriber."""

_DEFAULT_RATE = 10.0

_EXPORTED = {"topic", "type", "time", "message"}
"""Fields of a line that ``bag export --format jsonl`` wrote."""
_NUMBERS = frozenset(f"{kind}{bits}" for kind in ("int", "uint", "float") for bits in (8, 16, 32, 64))


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Publish messages given as arguments or as YAML documents."""
    name, type_name = invocation.resolve(args[0]), args[1]
    arguments = _values(args[2:])
    message_class = _load(type_name)
    has_fields = bool(message_class.__slots__)  # without fields there is nothing to read, like in stock
    from_arguments = not has_fields or (not options.file and (bool(arguments) or sys.stdin.isatty()))
    if from_arguments:  # wrong arguments are reported without a master
        fill(message_class(), arguments, Time())
    rate = options.rate
    with invocation.open_node() as node:
        latch = bool(options.latch) or rate is None
        publisher = node.advertise(name, message_class, queue_size=100, latch=latch)
        run = _Publishing(invocation, node, publisher, message_class, options)
        if not from_arguments:
            source = _documents_for_topic(_documents(options.file), name, invocation)
            keep_first = bool(options.latch) and rate is None
            if options.file and not (options.once or keep_first):
                first = list(islice(source, 2))
                if len(first) == 1:
                    run.repeat_from_file(first[0], rate or _DEFAULT_RATE, bool(options.substitute_keywords))
                    return
                source = chain(first, source)
            run.stream(source, rate or _DEFAULT_RATE, keep_first=keep_first)
        elif rate is not None:
            run.repeat(arguments, rate, bool(options.substitute_keywords))
        else:
            run.latched(arguments, bool(options.once))


def _parse(invocation: Invocation, verb: Verb) -> tuple[Any, list[str]]:
    """Parse the words. ``-1`` may be the option or a value."""
    options, args = parse_guarded(invocation, verb, _guarded(invocation.args, once=True))
    if "-1" in invocation.args and not options.file and len(args) > 1 and _needs_more_values(args[1], args[2:]):
        options, args = parse_guarded(invocation, verb, _guarded(invocation.args, once=False))
    if options.rate is not None:
        if options.once:
            raise UsageError("You cannot select both -r and -1 (--once)")
        try:
            options.rate = float(unguard(options.rate))
        except ValueError:
            raise UsageError("rate must be a number") from None
        if options.rate <= 0:
            raise UsageError("rate must be greater than zero")
    if not args:
        raise UsageError("/topic must be specified")
    if len(args) == 1:
        raise UsageError("topic type must be specified")
    if options.file and len(args) > 2:
        raise UsageError("args conflict with -f setting")
    if options.file and not os.path.isfile(options.file):
        raise CommandError(f"file does not exist: {options.file}")
    return options, args


VERB = Verb(
    "pub",
    "publish data to topic",
    Flag("-v", dest="verbose", help="print verbose output"),
    Option(
        "-r",
        "--rate",
        metavar="RATE",
        help="publishing rate (hz).  For -f and stdin input, this defaults to 10.  Otherwise it is not set.",
    ),
    Flag("-1", "--once", help="publish one message and exit"),
    Option("-f", "--file", metavar="FILE", help="read args from YAML file (Bagy)"),
    Flag("-l", "--latch", help="enable latching for -f, -r and piped input.  This latches the first message."),
    Flag(
        "-s",
        "--substitute-keywords",
        help="When publishing with a rate, performs keyword ('now' or 'auto') substitution for each message",
    ),
    Flag("--use-rostime", help="use rostime for time stamps, else walltime is used"),
    Argument("/topic", "topic"),
    Argument("type", "topic_type"),
    Argument("args", "message_text", many=True, optional=True),
    usage="/topic type [args...]",
    examples=[
        ("/vel_cmd std_msgs/Float64 1.0", "publish once, and keep it latched for later subscribers"),
        ("-r 10 /cmd_vel geometry_msgs/Twist '{linear: {x: 0.1}}'", "ten times a second"),
        ("-1 /goal geometry_msgs/PoseStamped '{header: auto}'", "once, and exit"),
        ("-f odom.jsonl /odom nav_msgs/Odometry", "publish the output of `topic echo --json`"),
    ],
    parse=_parse,
    run=run,
)


def _guarded(words: list[str], *, once: bool) -> list[str]:
    """Return the words with negative numbers marked as values.

    Args:
        once: ``-1`` is the option at any position, as in stock; otherwise only before the values.
    """
    guarded: list[str] = []
    positional = 0
    for number, word in enumerate(words):
        if word == "--":
            return guarded + words[number:]
        option = word == "-1" and (once or positional < 2)
        guarded.append(word if option else guard(word))
        positional += not word.startswith("-")
    return guarded


def _needs_more_values(type_name: str, words: list[str]) -> bool:
    """Return whether a message needs more values than these, so that a ``-1`` after its type must be one."""
    try:
        kinds = load_message(type_name)._slot_types
        value = load_yaml(words[0]) if words else None
    except (Error, ValueError):
        return False  # which is reported in a moment
    if not words:  # values may also come from stdin, but rarely numbers
        return all(kind in _NUMBERS for kind in kinds) and bool(kinds)
    return len(words) < len(kinds) and not isinstance(value, dict)


def _values(words: list[str]) -> list[Any]:
    values = []
    for word in words:
        try:
            values.append(load_yaml(word) if word else word)
        except Error as error:
            raise UsageError(f"Argument error: {error}") from None
    return values


def _suggested_type(type_name: str) -> str:
    """Return a hint at the type that may be meant by a misspelt name or a name without package."""
    try:
        load_message(type_name)
    except UnknownTypeError as error:
        hint = re.search(r" \(did you mean .*\?\)", str(error))
        return hint[0] if hint else ""
    return ""


def _load(type_name: str) -> type[Message]:
    package, _, name = type_name.partition("/")
    if not package or not name or "/" in name:
        raise CommandError(f"invalid topic type: {type_name}{_suggested_type(type_name)}")
    try:
        return load_message(type_name)
    except DefinitionError:
        raise
    except UnknownTypeError:
        raise CommandError(
            f"invalid message type: {type_name}{_suggested_type(type_name)}.\n"
            f"If this is a valid message type, perhaps you need to type 'rosmake {package}'"
        ) from None


def fill(message: Message, arguments: Any, now: Time | None) -> None:
    """Fill a message from the values of the arguments, and check that they fit.

    Raises:
        CommandError: they do not fit; the text says what is expected (L68).
    """
    try:
        fill_message(message, arguments, now)
    except MessageError as error:
        expected = " ".join(argument_names(type(message)))
        raise CommandError(f"{error}\n\nArgs are: [{expected}]") from None
    try:
        type(message)._encode(message)
    except SerializationError as error:
        expected = " ".join(argument_names(type(message)))
        raise CommandError(f"{error}\n\nArgs are: [{expected}]") from None


def _from_record(message_class: type[Message], record: Record, now: Time) -> Message:
    from pyros1.msgs.json_form import from_json  # noqa: PLC0415

    try:
        message = from_json(message_class, record, now)
        message_class._encode(message)
    except MessageError as error:
        raise CommandError(f"{error}\n\nArgs are: [{' '.join(argument_names(message_class))}]") from None
    return message


def _documents(path: str | None) -> Iterator[Any]:
    if path is None:
        yield from documents(sys.stdin, "stdin")
        return
    with open(path, encoding="utf-8") as file:
        yield from documents(file, path)


def _documents_for_topic(source: Iterator[Any], name: str, invocation: Invocation) -> Iterator[Any]:
    """Yield documents unchanged; of lines that `bag export` wrote, yield the messages of one topic.

    Raises:
        CommandError: there are such lines, but none for the topic.
    """
    skipped: set[str] = set()
    found = False
    for document in source:
        exported = isinstance(document, Record) and document.keys() == _EXPORTED
        if exported and invocation.resolve(str(document["topic"])) != name:
            skipped.add(str(document["topic"]))
            continue
        found = True
        yield Record(document["message"]) if exported else document
    if skipped and not found:
        raise CommandError(
            f"no line is for {name}; the lines are for: {', '.join(sorted(skipped))}. Use a remapping to rename a topic"
        )


def _arguments(document: Any) -> Any:
    return document if isinstance(document, (list, dict)) else [document]


class _Publishing:
    def __init__(
        self, invocation: Invocation, node: Any, publisher: Any, message_class: type[Message], options: Any
    ) -> None:
        self._invocation = invocation
        self._node = node
        self._publisher = publisher
        self._class = message_class
        self._verbose = bool(options.verbose)
        self._once = bool(options.once)
        self._rostime = bool(options.use_rostime)

    def _message(self, arguments: Any) -> Message:
        now = self._node.now() if self._rostime else Time.from_sec(time())
        if isinstance(arguments, Record):
            return _from_record(self._class, arguments, now)
        message = self._class()
        fill(message, arguments, now)
        return message

    def _description(self, message: Message) -> str:
        return f"[{message}]" if self._verbose else "message"

    def latched(self, arguments: Any, once: bool) -> None:
        """Publish one message, latched for later subscribers."""
        message = self._message(arguments)
        until = f" for {HOLD_SECONDS} seconds" if once else ". Press ctrl-C to terminate"
        print(f"publishing and latching {self._description(message)}{until}", flush=True)
        self._publisher.publish(message)
        if once:
            self._invocation.pause(HOLD_SECONDS)
        else:
            self._node.spin()

    def repeat_from_file(self, document: Any, rate: float, substitute: bool) -> None:
        """Publish the only message of a file repeatedly, like stock."""
        self._message(_arguments(document))  # a wrong one is reported immediately
        self._publisher.wait_for_subscribers(timeout=_SUBSCRIBER_TIMEOUT)
        print("Got one message and a rate, publishing repeatedly", flush=True)
        self.repeat(_arguments(document), rate, substitute)

    def repeat(self, arguments: Any, rate: float, substitute: bool) -> None:
        """Publish one message repeatedly."""
        message = self._message(arguments)
        pace = self._node.rate(rate)
        while self._node.ok():
            if substitute:
                message = self._message(arguments)
            if self._verbose:
                print(f"publishing {message}", flush=True)
            self._publisher.publish(message)
            pace.sleep()

    def stream(self, source: Iterator[Any], rate: float, *, keep_first: bool) -> None:
        """Publish one message for each document. ``keep_first``: only the first, latched for later subscribers."""
        pace = self._node.rate(rate)
        waited = False
        for document in source:
            if not self._node.ok():
                return
            arguments = _arguments(document)
            if keep_first:
                self.latched(arguments, self._once)
                return
            message = self._message(arguments)
            if not waited:
                waited = True
                self._publisher.wait_for_subscribers(timeout=_SUBSCRIBER_TIMEOUT)
            # Stock's text, even if the next message follows immediately.
            print(f"publishing and latching {self._description(message)} for {HOLD_SECONDS} seconds", flush=True)
            self._publisher.publish(message)
            if self._once:
                break
            pace.sleep()
        if waited:
            self._invocation.pause(HOLD_SECONDS if self._once or self._publisher.num_connections == 0 else 0.2)
