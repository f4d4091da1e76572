"""``pyros1 msg-proto msg|srv TYPE``: a template for ``topic pub`` or ``service call``, like rosmsg-proto (L89).

Stock's rosbash runs it for tab completion.
"""

from __future__ import annotations

import sys
from typing import Any

from pyros1.cli.failures import EX_USAGE
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Command, Flag, Option, Verb
from pyros1.ground.errors import Error
from pyros1.msgs import load_message, load_service
from pyros1.observe.template import template


def run(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Print a template of a message or service request. Return the exit code."""

    def print_error(text: str) -> None:
        if not options.silent:
            print(text, file=sys.stderr)

    if len(args) < 2:
        print_error("Insufficient arguments: give msg or srv, and a type")
        return EX_USAGE
    if args[0] not in ("msg", "srv"):
        print_error(f"Invalid type: {args[0]!r} is neither msg nor srv")
        return EX_USAGE
    excluded = (options.exclude_slots or "").split(",")
    try:
        text = template(
            load_class(args[0], args[1]), options.flow_style, empty_arrays=options.empty_arrays, excluded=excluded
        )
    except Error as error:
        print_error(f"Unknown {'message' if args[0] == 'msg' else 'service'} class: {error}")
        return 0 if options.silent else 1  # completion must not print errors
    text = "\n".join(options.prefix + line for line in text.split("\n"))
    print(text if options.no_hyphens else f'"{text}"')
    return 0


COMMAND = Command(
    "msg-proto",
    "print a template of a message or service request",
    Verb(
        "",
        "",
        Option(
            "-f",
            "--flow_style",
            type="int",
            help="if 1 always use brackets, if 0 never use brackets. Default is a heuristic mix.",
        ),
        Flag("-e", "--empty-arrays", help="if true flexible size arrays are not filled with default instance"),
        Flag("-s", "--silent", help="suppress all error messages"),
        Option(
            "-p",
            "--prefix",
            metavar="prefix",
            default="",
            help="prefix to print before each line, can be used for indent",
        ),
        Flag("-H", "--no-hyphens", help="if true output has no outer hyphens"),
        Option("-x", "--exclude-slots", help="comma separated list of slot names not to print"),
        Argument("msg|srv", "definition_kind"),
        Argument("TYPE", "definition"),
        usage="msg|srv [options] TYPE",
        description="Prints a template of a message or service request to fill in. Shells use it for completion.",
        examples=[
            ("msg geometry_msgs/Twist", "print a message in quotes"),
            ("srv -H std_srvs/SetBool", "print a service request without quotes"),
        ],
        run=run,
    ),
    group="develop",
    stock="rosmsg-proto",
)


def load_class(extension: str, type_name: str) -> Any:
    """Return the class of a message or of a service request.

    Args:
        extension: ``msg`` or ``srv``.
        type_name: the name of the type, with or without the package.

    Raises:
        Error: the type is unknown.
    """
    if "/" not in type_name:
        from pyros1.cli.shared.definitions import MESSAGE_KIND, SERVICE_KIND, find_full_names  # noqa: PLC0415 - rarely needed: shell completion passes full names

        names, _ = find_full_names(MESSAGE_KIND if extension == "msg" else SERVICE_KIND, type_name)
        type_name = names[0] if names else type_name
    return load_message(type_name) if extension == "msg" else load_service(type_name)._request_class
