"""``pyros1 param``: rosparam (L80-L85)."""

from __future__ import annotations

import os
import sys
from optparse import OptionParser, Values
from typing import Any

from pyros1 import shown
from pyros1.cli.common import CommandError, Invocation, did_you_mean, guard_negatives, print_json, run, unguard
from pyros1.errors import MasterError, MasterUnreachableError, ParameterNotSetError
from pyros1.shown import foreign, one_line

INT_RANGE = range(-(2**31), 2**31)


def usage(program: str) -> str:
    """The command list."""
    about = "a command-line tool for getting, setting, and deleting parameters from the ROS Parameter Server."
    return f"""{program} is {about}

Commands:
\t{program} set\tset parameter
\t{program} get\tget parameter
\t{program} load\tload parameters from file
\t{program} dump\tdump parameters to file
\t{program} delete\tdelete parameter
\t{program} list\tlist parameter names
"""


def _parse(
    invocation: Invocation,
    arguments: str,
    most: int,
    missing: str,
    *options: tuple[tuple[str, ...], dict[str, Any]],
    json: bool = False,
) -> tuple[Values, list[str], OptionParser]:
    parser = invocation.parser(f"{invocation.verb} {arguments}")
    for names, settings in options:
        parser.add_option(*names, **settings)
    if json:
        invocation.add_json(parser)
    values, args = parser.parse_args(invocation.args)
    if missing and not args:
        parser.error(f"invalid arguments. Please specify a {missing}")
    if len(args) > most:
        parser.error("too many arguments")
    return values, args, parser


_VERBOSE = (("-v",), {"dest": "verbose", "default": False, "action": "store_true", "help": "turn on verbose output"})


def list_names(invocation: Invocation) -> None:
    """``param list [namespace]`` (L83)."""
    args, json = invocation.args, False
    if args and (len(args) > 1 or args[0].startswith("-")):
        options, args, _ = _parse(invocation, "[namespace]", 1, "", json=True)
        json = options.json
    names = [*map(foreign, invocation.master.get_param_names())]
    if args:
        prefix = invocation.resolve(args[0]).rstrip("/") + "/"
        names = [name for name in names if name.startswith(prefix)]
    if json:
        print_json(sorted(names))
    else:
        print(*sorted(names), sep="\n")


def get(invocation: Invocation) -> None:
    """``param get name`` (L81)."""
    pretty_option = (
        ("-p",),
        {"dest": "pretty", "default": False, "action": "store_true", "help": "pretty print. WARNING: not YAML-safe"},
    )
    options, args, _ = _parse(
        invocation, "[options] parameter", 1, "parameter name", pretty_option, _VERBOSE, json=True
    )
    name = invocation.resolve(args[0])
    if options.verbose:
        print(f"getting parameter [{name}]")
    try:
        value = invocation.master.get_param(name)
    except ParameterNotSetError:
        hint = did_you_mean(name, invocation.master.get_param_names())
        raise CommandError(f"Parameter [{name}] is not set{hint}") from None
    if options.json:
        print_json(_plain(value))
    elif options.pretty and isinstance(value, dict):
        for line in pretty_lines(value, ""):
            print(line)
    elif options.pretty and isinstance(value, str):
        print(value)
    else:
        print(_scalar_or_block(value))


def _plain(value: Any) -> Any:
    """The value for JSON: binary data as base64, times as text."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, bytes):
        import base64  # noqa: PLC0415

        return base64.b64encode(value).decode("ascii")
    return value if value is None or isinstance(value, (str, int, float)) else str(value)


def _scalar_or_block(value: Any) -> str:
    from pyros1.values import dump_yaml  # noqa: PLC0415 - listing names needs no YAML

    text = dump_yaml(value)
    return text[: -len("\n...\n")] if text.endswith("\n...\n") else text


def pretty_lines(value: dict[str, Any], indent: str) -> list[str]:
    """A dictionary for people: strings without quotes, longer ones as blocks."""
    lines = []
    for name in sorted(value):
        item, key = value[name], one_line(name)
        if isinstance(item, dict):
            lines += [f"{indent}{key}:", *pretty_lines(item, indent + "  ")]
        elif isinstance(item, str):
            if "\n" in item:
                lines += [f"{indent}{key}: |", *(f"{indent}  {line}" for line in shown.lines(item).split("\n"))]
            else:
                lines.append(f"{indent}{key}: {shown.lines(item)}")
        else:
            lines.append(f"{indent}{key}: {_scalar_or_block(item)}".rstrip("\n"))
    return lines


def set_value(invocation: Invocation) -> None:
    """``param set name value`` (L80)."""
    invocation.args = guard_negatives(invocation.args)
    file = {"help": "set parameters to contents of text file", "metavar": "TEXT_FILE", "dest": "text_file"}
    binary = {"help": "set parameters to contents of binary file", "metavar": "BINARY_FILE", "dest": "bin_file"}
    options, args, parser = _parse(
        invocation,
        "[options] parameter value",
        2,
        "parameter name",
        (("-t", "--textfile"), file),
        (("-b", "--binfile"), binary),
        _VERBOSE,
    )
    args = [unguard(arg) for arg in args]
    name = invocation.resolve(args[0])
    if options.text_file and options.bin_file:
        parser.error("you may only specify one of --textfile or --binfile")
    if options.text_file:
        if not os.path.isfile(options.text_file):
            parser.error(f"file '{options.text_file}' does not exist")
        with open(options.text_file, encoding="utf-8") as text:
            _set(invocation, name, text.read(), options.verbose)
        return
    if options.bin_file:
        try:
            with open(options.bin_file, "rb") as data:
                content = data.read()
        except OSError as error:
            raise CommandError(f"cannot read [{options.bin_file}]: {error.strerror}") from None
        invocation.master.set_param(name, content)
        if options.verbose:
            print(f"set parameter [{name}] to [{content.decode('utf-8', 'replace')}]")
        return
    if len(args) < 2 or args[1] in ("-", "--"):
        parser.error("invalid arguments. Please specify a parameter value")
    if len(args) > 2:
        parser.error("too many arguments")
    from pyros1.values import load_yaml  # noqa: PLC0415

    _set(invocation, name, "" if args[1] == "" else load_yaml(args[1]), options.verbose)


def _set(
    invocation: Invocation, name: str, value: Any, verbose: bool, form: str = "set parameter [{}] to [{}]"
) -> None:
    """Set a value; a dictionary leaf by leaf, so that it is merged into what is there (L80)."""
    _check(value)
    leaves = list(_leaves(name, value))
    for leaf, item in leaves:
        if item is None:
            raise CommandError(f"Parameter [{leaf}] cannot be set to nothing (null)")
        try:
            invocation.master.set_param(leaf, item)
        except MasterUnreachableError:
            raise
        except MasterError as error:
            raise CommandError(str(error)) from None
        if verbose:
            print(form.format(leaf, item))


def _leaves(name: str, value: Any) -> list[tuple[str, Any]]:
    if not isinstance(value, dict):
        return [(name, value)]
    prefix = name.rstrip("/")
    return [leaf for key, item in value.items() for leaf in _leaves(f"{prefix}/{key}", item)]


def _check(value: Any) -> None:
    """Refuse what parameters cannot hold, before anything is set."""
    if isinstance(value, dict):
        if any(not isinstance(key, str) for key in value):
            raise CommandError(f"YAML dictionaries must have string keys. Invalid dictionary is:\n{value}")
        for item in value.values():
            _check(item)
    elif isinstance(value, (list, tuple)):
        for item in value:
            _check(item)
    elif isinstance(value, int) and value not in INT_RANGE:
        raise CommandError(f"the integer {value} does not fit into the 32 bits of a parameter")


def load(invocation: Invocation) -> None:
    """``param load file|- [namespace]`` (L82)."""
    options, args, _ = _parse(invocation, "[options] file [namespace]", 2, "file name or - for stdin", _VERBOSE)
    path = args[0]
    base = invocation.resolve(args[1]) if len(args) > 1 else invocation.namespace
    if path == "-":
        text, where = sys.stdin.read(), "stdin"
        source = "reading parameters from stdin"
    else:
        if not os.path.isfile(path):
            raise CommandError(f"file [{path}] does not exist")
        with open(path, encoding="utf-8") as file:
            text, where = file.read(), path
        source = f"reading parameters from [{path}]"
    if options.verbose:
        print(source)
    from pyros1.values import load_all_yaml  # noqa: PLC0415

    pending = []
    for document in load_all_yaml(text, where):
        if document is None:
            continue
        namespace = base
        if isinstance(document, dict) and "_ns" in document:
            namespace = _join(base, str(document.pop("_ns")))
            if options.verbose:
                print(f"reading parameters into namespace [{namespace}]")
        elif not isinstance(document, dict) and base == "/":
            raise CommandError(f"{where}: the root of the parameters must be a dictionary, not {document!r}")
        pending.append((namespace, document))
    for namespace, document in pending:
        _set(invocation, namespace, document, options.verbose, "{}={}")


def _join(base: str, name: str) -> str:
    from pyros1.names import canonicalize_name, ns_join  # noqa: PLC0415

    return canonicalize_name(ns_join(base, name))


def dump(invocation: Invocation) -> None:
    """``param dump [file] [namespace]`` (L82)."""
    options, args, _ = _parse(invocation, "[options] file [namespace]", 2, "", _VERBOSE)
    path = args[0] if args else None
    namespace = args[1] if len(args) > 1 else ""
    name = invocation.resolve(namespace)
    if options.verbose:
        print(f"dumping namespace [{namespace}] to file [{path}]")
    try:
        tree = invocation.master.get_param(name)
    except ParameterNotSetError as error:
        raise CommandError(str(error)) from None
    if options.verbose:
        for leaf, value in _leaves(name, tree):
            print(f"{leaf}={value}")
    from pyros1.values import dump_yaml  # noqa: PLC0415

    text = dump_yaml(tree)
    if path is None:
        sys.stdout.write(text)
        return
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)


def delete(invocation: Invocation) -> None:
    """``param delete name`` (L83)."""
    options, args, _ = _parse(invocation, "[options] parameter", 1, "parameter name", _VERBOSE)
    name = invocation.resolve(args[0])
    try:
        if name == "/":
            invocation.master.set_param("/", {})
        else:
            invocation.master.delete_param(name)
    except ParameterNotSetError:
        hint = did_you_mean(name, invocation.master.get_param_names())
        raise CommandError(f"parameter [{name}] is not set{hint}") from None
    if options.verbose:
        print(f"deleted parameter [{name}]")


_VERBS = {"set": set_value, "get": get, "load": load, "dump": dump, "delete": delete, "list": list_names}


def main(argv: list[str]) -> int:
    """Run ``param <verb> ...``; returns the exit code."""
    return run("rosparam", argv, _VERBS, usage, usage_code=0)
