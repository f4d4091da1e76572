"""``topic pub``: publishes messages given as YAML or JSON (L67-L69)."""

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
from pyros1.cli.parsing import mark_negative_number, parse_marked, unmark
from pyros1.cli.records import Argument, Flag, Option, Verb
from pyros1.cli.shared.argument_names import argument_names
from pyros1.cli.shared.documents import JsonDocument, read_documents
from pyros1.ground.errors import DefinitionError, Error, MessageError, SerializationError, UnknownTypeError
from pyros1.ground.timing import Time
from pyros1.msgs import Message, load_message
from pyros1.msgs.fill import fill_message
from pyros1.values import load_yaml

HOLD_SECONDS = 3.0
"""Time in seconds for which ``topic pub -1`` keeps running, so that subscribers can receive the message."""

_SUBSCRIBER_TIMEOUT = 5.0
"""Maximum time in seconds to wait for the first subscriber before messages from a file or stdin are published."""

_DEFAULT_RATE = 10.0

_EXPORT_FIELDS = {"topic", "type", "time", "message"}
"""Fields of a line from ``bag export --format jsonl``."""
_NUMERIC_TYPES = frozenset(f"{kind}{bits}" for kind in ("int", "uint", "float") for bits in (8, 16, 32, 64))


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Publish messages given as arguments or as YAML documents."""
    name, type_name = invocation.resolve(args[0]), args[1]
    arguments = _parse_values(args[2:])
    message_class = _load_message_class(type_name)
    has_fields = bool(message_class.__slots__)  # as in stock ROS, nothing is read for types without fields
    uses_arguments = not has_fields or (not options.file and (bool(arguments) or sys.stdin.isatty()))
    if uses_arguments:  # report invalid arguments before contacting the master
        fill_and_check(message_class(), arguments, Time())
    rate = options.rate
    with invocation.open_node() as node:
        latch = bool(options.latch) or rate is None
        publisher = node.advertise(name, message_class, queue_size=100, latch=latch)
        session = _PublishingSession(invocation, node, publisher, message_class, options)
        if not uses_arguments:
            source = _documents_for_topic(_read_source(options.file), name, invocation)
            latch_first = bool(options.latch) and rate is None
            if options.file and not (options.once or latch_first):
                first_documents = list(islice(source, 2))
                if len(first_documents) == 1:
                    session.repeat_from_file(
                        first_documents[0], rate or _DEFAULT_RATE, bool(options.substitute_keywords)
                    )
                    return
                source = chain(first_documents, source)
            session.stream(source, rate or _DEFAULT_RATE, latch_first=latch_first)
        elif rate is not None:
            session.repeat(arguments, rate, bool(options.substitute_keywords))
        else:
            session.publish_latched(arguments, bool(options.once))


def _parse(invocation: Invocation, verb: Verb) -> tuple[Any, list[str]]:
    """Parse the arguments, in which ``-1`` can be the option or a value. Return the options and other arguments."""
    options, args = parse_marked(invocation, verb, _mark_numbers(invocation.args, once_flag_anywhere=True))
    if "-1" in invocation.args and not options.file and len(args) > 1 and _needs_more_values(args[1], args[2:]):
        options, args = parse_marked(invocation, verb, _mark_numbers(invocation.args, once_flag_anywhere=False))
    if options.rate is not None:
        if options.once:
            raise UsageError("You cannot select both -r and -1 (--once)")
        try:
            options.rate = float(unmark(options.rate))
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
    Argument("args", "message_template", repeatable=True, optional=True),
    usage="/topic type [args...]",
    examples=[
        ("/vel_cmd std_msgs/Float64 1.0", "publish a message and keep it latched for later subscribers"),
        ("-r 10 /cmd_vel geometry_msgs/Twist '{linear: {x: 0.1}}'", "publish ten times per second"),
        ("-1 /goal geometry_msgs/PoseStamped '{header: auto}'", "publish once and exit"),
        ("-f odom.jsonl /odom nav_msgs/Odometry", "publish the output of `topic echo --json`"),
    ],
    parse=_parse,
    run=run,
)


def _mark_numbers(args: list[str], *, once_flag_anywhere: bool) -> list[str]:
    """Return the arguments with negative numbers marked as values.

    Args:
        args: the arguments.
        once_flag_anywhere: whether ``-1`` means ``--once`` at any position, as in stock ROS, or only before the values.
    """
    marked_args: list[str] = []
    positional_count = 0
    for position, arg in enumerate(args):
        if arg == "--":
            return marked_args + args[position:]
        is_option = arg == "-1" and (once_flag_anywhere or positional_count < 2)
        marked_args.append(arg if is_option else mark_negative_number(arg))
        positional_count += not arg.startswith("-")
    return marked_args


def _needs_more_values(type_name: str, values: list[str]) -> bool:
    """Return whether a message needs more values than are given. If so, a ``-1`` after these values is a value."""
    try:
        field_types = load_message(type_name)._slot_types
        value = load_yaml(values[0]) if values else None
    except (Error, ValueError):
        return False  # the error is reported later
    if not values:  # values are probably read from stdin, unless all fields are numbers
        return all(field_type in _NUMERIC_TYPES for field_type in field_types) and bool(field_types)
    return len(values) < len(field_types) and not isinstance(value, dict)


def _parse_values(args: list[str]) -> list[Any]:
    values = []
    for arg in args:
        try:
            values.append(load_yaml(arg) if arg else arg)
        except Error as error:
            raise UsageError(f"Argument error: {error}") from None
    return values


def _similar_type_hint(type_name: str) -> str:
    """Return a hint with the type that is probably meant by a name that is misspelt or lacks a package."""
    try:
        load_message(type_name)
    except UnknownTypeError as error:
        hint = re.search(r" \(did you mean .*\?\)", str(error))
        return hint[0] if hint else ""
    return ""


def _load_message_class(type_name: str) -> type[Message]:
    package, _, name = type_name.partition("/")
    if not package or not name or "/" in name:
        raise CommandError(f"invalid topic type: {type_name}{_similar_type_hint(type_name)}")
    try:
        return load_message(type_name)
    except DefinitionError:
        raise
    except UnknownTypeError:
        raise CommandError(
            f"invalid message type: {type_name}{_similar_type_hint(type_name)}.\n"
            f"If this is a valid message type, perhaps you need to type 'rosmake {package}'"
        ) from None


def fill_and_check(message: Message, arguments: Any, now: Time | None) -> None:
    """Set the fields of a message from arguments, and check that the values fit.

    Raises:
        CommandError: the values do not fit; the error message contains the names of the fields (L68).
    """
    try:
        fill_message(message, arguments, now)
    except MessageError as error:
        field_names = " ".join(argument_names(type(message)))
        raise CommandError(f"{error}\n\nArgs are: [{field_names}]") from None
    try:
        type(message)._encode(message)
    except SerializationError as error:
        field_names = " ".join(argument_names(type(message)))
        raise CommandError(f"{error}\n\nArgs are: [{field_names}]") from None


def _message_from_json(message_class: type[Message], document: JsonDocument, now: Time) -> Message:
    from pyros1.msgs.json_form import from_json  # noqa: PLC0415

    try:
        message = from_json(message_class, document, now)
        message_class._encode(message)
    except MessageError as error:
        raise CommandError(f"{error}\n\nArgs are: [{' '.join(argument_names(message_class))}]") from None
    return message


def _read_source(path: str | None) -> Iterator[Any]:
    if path is None:
        yield from read_documents(sys.stdin, "stdin")
        return
    with open(path, encoding="utf-8") as file:
        yield from read_documents(file, path)


def _documents_for_topic(documents: Iterator[Any], name: str, invocation: Invocation) -> Iterator[Any]:
    """Yield the documents to publish. From lines of `bag export`, yield the messages of one topic.

    Raises:
        CommandError: there are lines of `bag export`, but none for the topic.
    """
    skipped_topics: set[str] = set()
    has_documents = False
    for document in documents:
        is_exported = isinstance(document, JsonDocument) and document.keys() == _EXPORT_FIELDS
        if is_exported and invocation.resolve(str(document["topic"])) != name:
            skipped_topics.add(str(document["topic"]))
            continue
        has_documents = True
        yield JsonDocument(document["message"]) if is_exported else document
    if skipped_topics and not has_documents:
        raise CommandError(
            f"no line contains a message of {name}, only of: {', '.join(sorted(skipped_topics))}. "
            "Use a remapping to rename a topic"
        )


def _as_arguments(document: Any) -> Any:
    return document if isinstance(document, (list, dict)) else [document]


class _PublishingSession:
    def __init__(
        self, invocation: Invocation, node: Any, publisher: Any, message_class: type[Message], options: Any
    ) -> None:
        self._invocation = invocation
        self._node = node
        self._publisher = publisher
        self._message_class = message_class
        self._is_verbose = bool(options.verbose)
        self._exits_after_one = bool(options.once)
        self._uses_ros_time = bool(options.use_rostime)

    def _make_message(self, arguments: Any) -> Message:
        now = self._node.now() if self._uses_ros_time else Time.from_sec(time())
        if isinstance(arguments, JsonDocument):
            return _message_from_json(self._message_class, arguments, now)
        message = self._message_class()
        fill_and_check(message, arguments, now)
        return message

    def _description(self, message: Message) -> str:
        return f"[{message}]" if self._is_verbose else "message"

    def publish_latched(self, arguments: Any, once: bool) -> None:
        """Publish one latched message and wait until the node shuts down, or, with `once`, for `HOLD_SECONDS`."""
        message = self._make_message(arguments)
        until_text = f" for {HOLD_SECONDS} seconds" if once else ". Press ctrl-C to terminate"
        print(f"publishing and latching {self._description(message)}{until_text}", flush=True)
        self._publisher.publish(message)
        if once:
            self._invocation.pause(HOLD_SECONDS)
        else:
            self._node.spin()

    def repeat_from_file(self, document: Any, rate: float, substitutes_keywords: bool) -> None:
        """Publish the only message of a file repeatedly, like rostopic."""
        self._make_message(_as_arguments(document))  # report an invalid document immediately
        self._publisher.wait_for_subscribers(timeout=_SUBSCRIBER_TIMEOUT)
        print("Got one message and a rate, publishing repeatedly", flush=True)
        self.repeat(_as_arguments(document), rate, substitutes_keywords)

    def repeat(self, arguments: Any, rate: float, substitutes_keywords: bool) -> None:
        """Publish one message repeatedly."""
        message = self._make_message(arguments)
        publishing_rate = self._node.rate(rate)
        while self._node.ok():
            if substitutes_keywords:
                message = self._make_message(arguments)
            if self._is_verbose:
                print(f"publishing {message}", flush=True)
            self._publisher.publish(message)
            publishing_rate.sleep()

    def stream(self, source: Iterator[Any], rate: float, *, latch_first: bool) -> None:
        """Publish a message for each document; with `latch_first`, only the first, latched for later subscribers."""
        publishing_rate = self._node.rate(rate)
        has_waited = False
        for document in source:
            if not self._node.ok():
                return
            arguments = _as_arguments(document)
            if latch_first:
                self.publish_latched(arguments, self._exits_after_one)
                return
            message = self._make_message(arguments)
            if not has_waited:
                has_waited = True
                self._publisher.wait_for_subscribers(timeout=_SUBSCRIBER_TIMEOUT)
            # rostopic prints this even if the next message follows immediately.
            print(f"publishing and latching {self._description(message)} for {HOLD_SECONDS} seconds", flush=True)
            self._publisher.publish(message)
            if self._exits_after_one:
                break
            publishing_rate.sleep()
        if has_waited:
            self._invocation.pause(
                HOLD_SECONDS if self._exits_after_one or self._publisher.num_connections == 0 else 0.2
            )
