"""``bag info`` (L114-L116)."""

from __future__ import annotations

import errno
import re
import sys
from typing import Any

from pyros1.bag.errors import BagError, EncryptedError, UnindexedError
from pyros1.bag.info import info_text, info_values, summarize, yaml_text
from pyros1.bag.reader import BagReader
from pyros1.cli.common import Invocation, flush
from pyros1.shown import json_text

_WRITING = (errno.ENOSPC, errno.EFBIG, errno.EDQUOT, errno.EROFS)
_STEP = re.compile(r"\.?([A-Za-z_]\w*)|\[(-?\d+)\]")


def info(invocation: Invocation) -> int:
    """``bag info [options] BAG...``."""
    parser = invocation.parser("info [options] BAGFILE1 [BAGFILE2 BAGFILE3 ...]")
    parser.description = "Summarize the contents of one or more bag files."
    parser.add_option("-y", "--yaml", action="store_true", default=False, help="print information in YAML format")
    parser.add_option("-k", "--key", help="print information on the given key, such as duration or topics[0].type")
    parser.add_option("--freq", action="store_true", default=False, help="display topic message frequency statistics")
    invocation.add_json(parser, "print one line of JSON per bag")
    options, paths = parser.parse_args(invocation.args)
    if not paths:
        parser.error("You must specify at least 1 bag file.")
    if options.key and not options.yaml:
        parser.error("You can only specify key when printing in YAML format.")
    failed = False
    for number, path in enumerate(paths):
        try:
            with BagReader(path) as bag:
                summary = summarize(bag, frequencies=options.freq)
        except (BagError, OSError) as error:
            report_bag_error(error, path)
            if isinstance(error, EncryptedError):
                failed = True
                continue
            return 1
        if options.json:
            import json  # noqa: PLC0415

            print(json_text(json.dumps(_typed(info_values(summary)), ensure_ascii=False)))
            continue
        if not options.yaml:
            print(info_text(summary))
        elif options.key:
            _print_key(info_values(summary), options.key)
        else:
            print(yaml_text(info_values(summary)))
        if number < len(paths) - 1:
            print("---")
    return int(failed)


def report_bag_error(error: BagError | OSError, path: str) -> None:
    """Print what is wrong with a bag, and what to do, to stderr."""
    flush()
    if isinstance(error, UnindexedError):
        print(f"ERROR bag unindexed: {error}", file=sys.stderr)
    elif isinstance(error, BagError):
        print(f"ERROR reading {error}", file=sys.stderr)
    else:
        verb = "writing" if error.errno in _WRITING else "reading"
        what = f"{verb} {path}" if error.filename in (None, path) else error.filename
        print(f"ERROR {what}: {error.strerror or error}", file=sys.stderr)


def _typed(value: Any) -> Any:
    """Values as YAML reads them: numbers that were texts with a fixed number of digits."""
    if isinstance(value, dict):
        return {name: _typed_field(name, item) for name, item in value.items()}
    if isinstance(value, list):
        return [_typed(item) for item in value]
    return value


def _typed_field(name: str, value: Any) -> Any:
    if name in ("duration", "start", "end", "frequency") or (name == "version" and "(" not in value):
        return float(value)
    return _typed(value)


def _print_key(values: dict[str, Any], key: str) -> None:
    try:
        value = _find(_typed(values), key)
    except (LookupError, ValueError):
        print(f'Error getting key "{key}"', file=sys.stderr)
        return
    print(_key_text(value))


def _find(value: Any, key: str) -> Any:
    """The value of a path such as ``topics[0].type``."""
    position = 0
    while position < len(key):
        step = _STEP.match(key, position)
        if step is None:
            raise ValueError(key)
        name, index = step.groups()
        if name is not None and not isinstance(value, dict):
            raise LookupError(key)
        if index is not None and not isinstance(value, list):
            raise LookupError(key)
        value = value[name] if name is not None else value[int(index)]
        position = step.end()
    return value


def _key_text(value: Any, indent: str = "") -> str:
    if isinstance(value, list):
        return "".join(f"{indent}- {_key_text(item, indent + '  ')}\n" for item in value)
    if isinstance(value, dict):
        return f"\n{indent}".join(f"{name}: {item}" for name, item in value.items())
    return f"{indent}{value}"
