"""``topic type`` prints the type of a topic, and ``topic find`` the topics of a type (L29, L30)."""

from __future__ import annotations

from typing import Any

from pyros1.cli.failures import UsageError, did_you_mean, fail
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import JSON_FLAG, Argument, Option, Verb
from pyros1.cli.shared.printing import print_json


def _print_type(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the type of a topic or field."""
    if not args:
        raise UsageError("the following arguments are required: topic_or_field")
    if len(args) > 1:
        raise UsageError(f"unrecognized arguments: {' '.join(args[1:])}")
    name = invocation.resolve(args[0])
    graph = invocation.graph
    topic_match = graph.find_topic(name)
    if topic_match is None:
        fail(f"unknown topic type [{name}]{did_you_mean(name, graph.topic_types())}")
    _, topic_type, path = topic_match
    if not path:
        print(topic_type)
        return
    from pyros1.ground.errors import MessageError  # noqa: PLC0415
    from pyros1.msgs import load_message  # noqa: PLC0415
    from pyros1.observe.fields import FieldPath, FieldPathError  # noqa: PLC0415 - only needed for fields

    try:
        field_type = FieldPath(path).type_in(load_message(topic_type))
    except (FieldPathError, MessageError):
        fail(f"unknown topic type [{name}]")
    print(topic_type, path.lstrip("/"), field_type)


def _print_topics(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the topics of a type, or the topics with a name or type similar to a word."""
    if not args and options.like is None:
        raise UsageError("please specify a message type")
    if len(args) > 1:
        raise UsageError("you may only specify one message type")
    types = invocation.graph.topic_types()
    names = [topic for topic, topic_type in types.items() if args and topic_type == args[0]]
    if options.like is not None:
        names += [name for name in _find_similar(options.like, types) if name not in names]
    if options.json:
        print_json([{"topic": topic, "type": types[topic]} for topic in names])
    else:
        print(*names, sep="\n")


def _find_similar(word: str, types: dict[str, str]) -> list[str]:
    """Return the topics whose name or type contains a word, or has a part similar to it, best matches first."""
    from difflib import get_close_matches  # noqa: PLC0415

    lowercase_word = word.lower().strip("/")
    names = sorted(types)
    matches = [name for name in names if lowercase_word in name.lower()]
    matches += [name for name in names if lowercase_word in types[name].lower()]
    for name in names:
        parts = [part.lower() for part in (*name.split("/"), *types[name].split("/")) if part]
        if get_close_matches(lowercase_word, parts, 1, 0.7):
            matches.append(name)
    return list(dict.fromkeys(matches))


VERBS = [
    Verb(
        "type",
        "print topic or field type",
        Argument("topic_or_field", "topic"),
        examples=[("/pose/header/stamp", "print the type of a topic or field")],
        run=_print_type,
    ),
    Verb(
        "find",
        "find topics by type",
        JSON_FLAG,
        Option(
            "--like",
            metavar="WORD",
            pyros1_only=True,
            help="also list topics whose name or type contains the word or is similar to it",
        ),
        Argument("msg-type", "message_type"),
        usage="msg-type",
        examples=[
            ("std_msgs/String", "list the topics of a type"),
            ("--like scan", "list topics with a similar name or type"),
        ],
        run=_print_topics,
    ),
]
