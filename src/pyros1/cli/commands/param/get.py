"""``param get``: prints parameters (L81)."""

from __future__ import annotations

from typing import Any

from pyros1.cli.commands.param._arguments import VERBOSE_FLAG, check_arguments
from pyros1.cli.failures import CommandError, did_you_mean
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import JSON_FLAG, Argument, Flag, Verb
from pyros1.cli.shared.printing import print_json
from pyros1.ground import terminal_text
from pyros1.ground.errors import ParameterNotSetError
from pyros1.ground.terminal_text import one_line


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print a parameter, or all parameters below a name."""
    check_arguments(args, 1, "parameter name")
    parameter_name = invocation.resolve(args[0])
    if options.verbose:
        print(f"getting parameter [{parameter_name}]")
    try:
        value = invocation.master.get_param(parameter_name)
    except ParameterNotSetError:
        hint = did_you_mean(parameter_name, invocation.master.get_param_names())
        raise CommandError(f"Parameter [{parameter_name}] is not set{hint}") from None
    if options.json:
        print_json(as_json(value))
    elif options.pretty and isinstance(value, dict):
        for line in _pretty_lines(value, ""):
            print(line)
    elif options.pretty and isinstance(value, str):
        print(value)
    else:
        print(yaml_text(value))


VERB = Verb(
    "get",
    "get parameter",
    Flag("-p", dest="pretty", help="pretty print. WARNING: not YAML-safe"),
    VERBOSE_FLAG,
    JSON_FLAG,
    Argument("parameter", "param"),
    examples=[("/gain", "print a value"), ("/robot1", "print everything below a name as YAML")],
    run=run,
)


def as_json(value: Any) -> Any:
    """Return the value in a form that JSON supports: binary data as base64, times as strings."""
    if isinstance(value, dict):
        return {key: as_json(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [as_json(item) for item in value]
    if isinstance(value, bytes):
        import base64  # noqa: PLC0415

        return base64.b64encode(value).decode("ascii")
    return value if value is None or isinstance(value, (str, int, float)) else str(value)


def yaml_text(value: Any) -> str:
    """Return a value as YAML, without the end-of-document marker."""
    from pyros1.values import dump_yaml  # noqa: PLC0415 - not needed for help

    text = dump_yaml(value)
    return text[: -len("\n...\n")] if text.endswith("\n...\n") else text


def _pretty_lines(value: dict[str, Any], indent: str) -> list[str]:
    """Return the lines of a dictionary in a readable form: strings without quotes, multi-line strings as blocks."""
    lines = []
    for name in sorted(value):
        item, key = value[name], one_line(name)
        if isinstance(item, dict):
            lines += [f"{indent}{key}:", *_pretty_lines(item, indent + "  ")]
        elif isinstance(item, str):
            if "\n" in item:
                lines += [f"{indent}{key}: |", *(f"{indent}  {line}" for line in terminal_text.lines(item).split("\n"))]
            else:
                lines.append(f"{indent}{key}: {terminal_text.lines(item)}")
        else:
            lines.append(f"{indent}{key}: {yaml_text(item)}".rstrip("\n"))
    return lines
