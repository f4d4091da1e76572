"""``bag info``: summarizes the contents of bags (L114-L116)."""

from __future__ import annotations

import re
import sys
from typing import Any

from pyros1.bag.errors import BagError, EncryptedError
from pyros1.bag.format.reader import BagReader
from pyros1.bag.info import info_text, info_values, summarize, yaml_text
from pyros1.cli.commands.bag._failures import report_bag_error
from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Flag, Option, Verb
from pyros1.cli.shared.options import CHUNK_LIMIT_OPTION
from pyros1.cli.shared.printing import print_json

_PATH_STEP = re.compile(r"\.?([A-Za-z_]\w*)|\[(-?\d+)\]")


def run(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Print a summary of each bag. Return 1 if a bag cannot be read, otherwise 0."""
    if not args:
        raise UsageError("You must specify at least 1 bag file.")
    if options.key and not options.yaml:
        raise UsageError("You can only specify key when printing in YAML format.")
    has_failed = False
    for index, path in enumerate(args):
        try:
            with BagReader(path) as bag:
                summary = summarize(bag, frequencies=options.freq)
        except (BagError, OSError) as error:
            report_bag_error(error, path)
            if isinstance(error, EncryptedError):
                has_failed = True
                continue
            return 1
        if options.json:
            print_json(_convert_numbers(info_values(summary)))
            continue
        if not options.yaml:
            print(info_text(summary))
        elif options.key:
            _print_value_at(info_values(summary), options.key)
        else:
            print(yaml_text(info_values(summary)))
        if index < len(args) - 1:
            print("---")
    return int(has_failed)


VERB = Verb(
    "info",
    "summarize the contents of one or more bag files",
    CHUNK_LIMIT_OPTION,
    Flag("-y", "--yaml", help="print information in YAML format"),
    Option("-k", "--key", help="print information on the given key, such as duration or topics[0].type"),
    Flag("--freq", help="display topic message frequency statistics"),
    Flag("--json", help="print one line of JSON per bag", pyros1_only=True),
    Argument("BAGFILE", "bag", repeatable=True),
    usage="[options] BAGFILE1 [BAGFILE2 BAGFILE3 ...]",
    description="Summarize the contents of one or more bag files.",
    examples=[
        ("run.bag", "print what a bag contains"),
        ("-y -k topics[0].type run.bag", "print one value, for scripts"),
        ("--json run.bag", "print JSON for programs"),
    ],
    run=run,
)


def _convert_numbers(value: Any) -> Any:
    """Convert values as a YAML parser does: strings of digits become numbers."""
    if isinstance(value, dict):
        return {name: _convert_field(name, item) for name, item in value.items()}
    if isinstance(value, list):
        return [_convert_numbers(item) for item in value]
    return value


def _convert_field(name: str, value: Any) -> Any:
    if name in ("duration", "start", "end", "frequency") or (name == "version" and "(" not in value):
        return float(value)
    return _convert_numbers(value)


def _print_value_at(values: dict[str, Any], key: str) -> None:
    try:
        value = _value_at(_convert_numbers(values), key)
    except (LookupError, ValueError):
        print(f'Error getting key "{key}"', file=sys.stderr)
        return
    print(_format_value(value))


def _value_at(value: Any, key: str) -> Any:
    """Return the value at a path such as ``topics[0].type``.

    Raises:
        LookupError: There is no such value.
        ValueError: The path is malformed.
    """
    position = 0
    while position < len(key):
        match = _PATH_STEP.match(key, position)
        if match is None:
            raise ValueError(key)
        name, index = match.groups()
        if name is not None and not isinstance(value, dict):
            raise LookupError(key)
        if index is not None and not isinstance(value, list):
            raise LookupError(key)
        value = value[name] if name is not None else value[int(index)]
        position = match.end()
    return value


def _format_value(value: Any, indent: str = "") -> str:
    if isinstance(value, list):
        return "".join(f"{indent}- {_format_value(item, indent + '  ')}\n" for item in value)
    if isinstance(value, dict):
        return f"\n{indent}".join(f"{name}: {item}" for name, item in value.items())
    return f"{indent}{value}"
