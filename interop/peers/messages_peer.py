"""Compares pyros1's message classes with genmsg's and genpy's, both in this process; prints a JSON report.

Run with the Python that has the stock packages, and pyros1's source on PYTHONPATH::

    messages_peer.py sums      md5, full text, constants of every type in /usr/share, and the shipped copies' md5
    messages_peer.py values N  N random values of every type: bytes both ways, defaults, text, filling
    messages_peer.py strings N printed form of N random strings, alone and in lists
"""

from __future__ import annotations

import io
import json
import math
import random
import struct
import sys
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import genmsg.gentools
import genmsg.msg_loader
import genpy
import genpy.dynamic
import genpy.message
from genmsg.msgs import bare_msg_type
from rostopic import create_value_transform

from pyros1.finding.library import Library
from pyros1.ground.timing import Duration, Time
from pyros1.msgs.dynamic import from_definition
from pyros1.msgs.factory import python_name
from pyros1.msgs.fill import fill_message
from pyros1.msgs.text import format_message

SHARE = Path("/usr/share")


def stock_types(kind: str) -> Iterator[str]:
    """Yield the full names of all definitions installed."""
    for path in sorted(SHARE.glob(f"*/{kind}/*.{kind}")):
        yield f"{path.parent.parent.name}/{path.stem}"


class Stock:
    """genmsg with all installed packages on its search path."""

    def __init__(self) -> None:
        self.context = genmsg.MsgContext.create_default()
        self.path: dict[str, list[str]] = {}
        for kind in ("msg", "srv"):
            for folder in SHARE.glob(f"*/{kind}"):
                self.path.setdefault(folder.parent.name, []).append(str(folder))

    def message(self, name: str) -> Any:
        spec = genmsg.msg_loader.load_msg_by_type(self.context, name, self.path)
        genmsg.msg_loader.load_depends(self.context, spec, self.path)
        return spec

    def service(self, name: str) -> Any:
        spec = genmsg.msg_loader.load_srv_by_type(self.context, name, self.path)
        genmsg.msg_loader.load_depends(self.context, spec, self.path)
        return spec

    def md5(self, spec: Any) -> str:
        return str(genmsg.gentools.compute_md5(self.context, spec))

    def full_text(self, spec: Any) -> str:
        return str(genmsg.gentools.compute_full_text(self.context, spec))


def sums() -> dict[str, Any]:
    stock = Stock()
    library = Library({}, installs=[SHARE])
    shipped = Library({}, installs=[])
    failures: list[str] = []
    count = {"messages": 0, "services": 0, "shipped": 0, "from actions": 0}

    def compare(what: str, theirs: Any, ours: Any) -> None:
        if theirs != ours:
            failures.append(f"{what}: stock {theirs!r}, pyros1 {ours!r}")

    for name in stock_types("msg"):
        theirs, ours = stock.message(name), library.message(name)
        count["messages"] += 1
        compare(f"{name} md5", stock.md5(theirs), library.digests.md5(ours))
        compare(f"{name} full text", stock.full_text(theirs), library.digests.full_text(ours))
        compare(f"{name} types", theirs.types, [field.type for field in ours.fields])
        compare(f"{name} names", theirs.names, [field.name for field in ours.fields])
        compare(f"{name} header", theirs.has_header(), ours.has_header)
        constants = [(c.type, c.name, c.val, c.val_text) for c in theirs.constants]
        compare(f"{name} constants", constants, [(c.type, c.name, c.value, c.text) for c in ours.constants])
        compare(f"{name} shipped md5", stock.md5(theirs), shipped.digests.md5(shipped.message(name)))
        count["shipped"] += 1
    for name in stock_types("srv"):
        theirs, ours = stock.service(name), library.service(name)
        count["services"] += 1
        compare(f"{name} md5", stock.md5(theirs), library.digests.md5(ours))
        for part in ("request", "response"):
            theirs_part, ours_part = getattr(theirs, part), getattr(ours, part)
            compare(f"{name} {part} md5", stock.md5(theirs_part), library.digests.md5(ours_part))
            compare(f"{name} {part} text", stock.full_text(theirs_part), library.digests.full_text(ours_part))
        compare(f"{name} shipped md5", stock.md5(theirs), shipped.digests.md5(shipped.service(name)))
        count["shipped"] += 1
    from pyros1.msgs.spec import action_messages

    for action in stock_types("action"):
        package, short = action.split("/")
        text = (SHARE / package / "action" / f"{short}.action").read_text()
        for name, made in action_messages(action, text).items():
            installed = SHARE / package / "msg" / f"{name.partition('/')[2]}.msg"
            compare(f"{name} text", installed.read_text(), made)
            count["from actions"] += 1
    return {"count": count, "failures": failures}


# -- values ------------------------------------------------------------------------------------------------------------


class Values:
    """Random messages of our classes, made of plain values."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)

    def single(self, base: str, classes: dict[str, Any]) -> Any:  # noqa: PLR0911  one per kind of type
        rng = self.random
        if base in classes:
            return self.message(classes[base])
        if base == "bool":
            return rng.random() < 0.5
        if base.startswith("float"):
            value = rng.choice([0.0, -1.5, 1e-7, rng.uniform(-1e6, 1e6), math.inf])
            return value if base == "float64" else struct.unpack("f", struct.pack("f", value))[0]
        if base == "string":
            letters = "aB ü\n#:😀0/-'\""
            return "".join(rng.choice(letters) for _ in range(rng.choice([0, 1, 3, 9, 60])))
        if base == "time":
            return Time(rng.choice([7, rng.randrange(2**32)]), rng.choice([0, 500_000_000, rng.randrange(10**9)]))
        if base == "duration":
            return Duration(rng.randrange(-(2**31), 2**31), rng.choice([0, 500_000_000, rng.randrange(10**9)]))
        base = {"byte": "int8", "char": "uint8"}.get(base, base)
        bits = int(base.lstrip("uint"))
        low = 0 if base[0] == "u" else -(1 << bits - 1)
        return rng.choice([low, low + (1 << bits) - 1, rng.randrange(low, low + (1 << bits))])

    def message(self, cls: Any) -> Any:
        values = []
        for slot_type in cls._slot_types:
            base, bracket, count = slot_type.partition("[")
            if not bracket:
                values.append(self.single(base, cls._classes))
                continue
            length = int(count[:-1]) if count != "]" else self.random.choice([0, 1, 3])
            items = [self.single(base, cls._classes) for _ in range(length)]
            values.append(bytes(items) if base in ("uint8", "char") else items)
        return cls(*values)


def to_stock(message: Any, classes: dict[str, Any]) -> Any:
    """Copy one of our messages into genpy's class of the same type."""
    result = classes[message._type]()
    for name, slot_type in zip(message.__slots__, message._slot_types, strict=True):
        value = getattr(message, name)
        base = bare_msg_type(slot_type)
        if base in ("time", "duration") or "/" in base:
            value = [stock_value(item, classes) for item in value] if "[" in slot_type else stock_value(value, classes)
        setattr(result, name, value)
    return result


def stock_value(value: Any, classes: dict[str, Any]) -> Any:
    if isinstance(value, Time):
        return genpy.Time(value.secs, value.nsecs)
    if isinstance(value, Duration):
        return genpy.Duration(value.secs, value.nsecs)
    return to_stock(value, classes)


def plain(message: Any, rng: random.Random) -> Any:
    """Return a message as the lists and dicts that ``rostopic pub`` takes."""

    def value(item: Any) -> Any:
        if isinstance(item, (Time, Duration)):
            forms: list[Any] = [[item.secs, item.nsecs], {"secs": item.secs, "nsecs": item.nsecs}]
            # Stock goes through a float, which cuts most numbers of nanoseconds.
            return rng.choice([item.to_nsec(), *forms] if 0 <= item.secs < 10 and item.nsecs == 500_000_000 else forms)
        if isinstance(item, (list, tuple)):
            return [value(element) for element in item]
        return plain(item, rng) if hasattr(item, "__slots__") else item

    fields = {name: value(getattr(message, name)) for name in message.__slots__}
    # A list with one dict in it would be taken for the dict.
    return fields if rng.random() < 0.5 or len(fields) < 2 else list(fields.values())


def encode_stock(message: Any) -> bytes:
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


def all_definitions() -> Iterator[tuple[str, str]]:
    library = Library({}, installs=[SHARE])
    for name in stock_types("msg"):
        yield name, library.digests.full_text(library.message(name))
    for name in stock_types("srv"):
        service = library.service(name)
        for part in (service.request, service.response):
            yield part.name, library.digests.full_text(part)


def values(rounds: int) -> dict[str, Any]:
    failures: list[str] = []
    count = {"types": 0, "values": 0, "filled": 0}
    for name, text in all_definitions():
        ours = from_definition(name, text)
        try:
            theirs = genpy.dynamic.generate_dynamic(name, text)
        except IndexError:  # genpy cannot build a class from an empty text
            short = name.partition("/")[2]
            theirs = {name: make_empty(short)} if not text.strip() else {}
        if name not in theirs:
            failures.append(f"{name}: genpy makes no class")
            continue
        count["types"] += 1
        problems = [problem for seed in range(rounds) for problem in one_value(ours, theirs, seed, count)]
        failures += [f"{name}: {problem}" for problem in problems[:3]]
    return {"count": count, "failures": failures}


def make_empty(short: str) -> Any:
    from std_msgs.msg import Empty

    return type(short, (Empty,), {"__slots__": [], "_slot_types": []})


def one_value(ours: Any, theirs: dict[str, Any], seed: int, count: dict[str, int]) -> Iterator[str]:
    stock = theirs[ours._type]
    message = Values(seed).message(ours) if seed else ours()
    copy = to_stock(message, theirs) if seed else stock()
    mine, other = ours._encode(message), encode_stock(copy)
    count["values"] += 1
    if mine != other:
        yield f"encodes to {mine!r}, genpy's to {other!r}"
        return
    frame = ours._encode_frame(message)
    if b"".join([frame] if isinstance(frame, bytes) else frame) != struct.pack("<I", len(mine)) + mine:
        yield "the frame is not length and body"
    decoded, their_decoded = ours._decode(other, 0, len(other)), stock().deserialize(mine)
    if decoded != message:
        yield f"does not come back: {decoded!r}"
    if ours._encode(decoded) != mine or encode_stock(their_decoded) != mine:
        yield "encodes otherwise after decoding"
    for field in ours.__slots__:
        mine_is, other_is = type(getattr(decoded, field)), type(getattr(their_decoded, field))
        if mine_is.__name__ != other_is.__name__ and not hasattr(mine_is, "_type"):
            yield f"[{field}] decodes to {mine_is}, genpy's to {other_is}"
    if str(message) != str(copy):
        yield f"prints {str(message)!r}, genpy {str(copy)!r}"
    if format_message(message, width=7) != genpy.message.strify_message(copy, fixed_numeric_width=7):
        yield "prints otherwise with a width"
    yield from filled(ours, stock, message, seed, count)


def filled(ours: Any, stock: Any, message: Any, seed: int, count: dict[str, int]) -> Iterator[str]:
    args = plain(message, random.Random(seed))
    args = [args] if isinstance(args, dict) else args
    mine, other = ours(), stock()
    try:
        genpy.message.fill_message_args(other, args)
    except genpy.MessageException as error:
        if "cannot load class" in str(error):  # arrays of a type whose Python module is not installed
            return
        raise
    fill_message(mine, args)
    count["filled"] += 1
    if ours._encode(mine) != encode_stock(other):
        yield f"filled with {args!r}: {mine!r}, genpy {other!r}"


# -- strings and hidden values -----------------------------------------------------------------------------------------


def strings(rounds: int) -> dict[str, Any]:
    rng = random.Random(1)
    pieces = [*"ab'\"\\:#-?10._e+xü\t\x85😀%,[/~\x7f=<\r\ufeff\u2028\xa0", "word", "yes", "null"]
    pieces += [" ", "  ", "\n", "word ", " word"]
    failures = []
    for _ in range(rounds):
        some = rng.choice(
            [pieces, ["word", " ", "a", "b", "'", "\n"], ["1", "0", ".", "e", "-", ":", "_", "x", "T", " "]]
        )
        text = "".join(rng.choice(some) for _ in range(rng.choice([1, 2, 3, 4, 6, 10, 40, 80])))
        for value in (text, [text, "a"]):
            mine, other = format_message(value, indent=" "), genpy.message.strify_message(value, indent=" ")
            if mine != other:
                failures.append(f"{value!r}: stock {other!r}, pyros1 {mine!r}")
    return {"count": {"strings": rounds}, "failures": failures[:10]}


def hidden() -> dict[str, Any]:
    """Compare --nostr and --noarr, for types whose Python modules are installed."""
    import importlib

    failures = []
    count = {"types": 0}
    library = Library({}, installs=[SHARE])
    for name in stock_types("msg"):
        package, short = name.split("/")
        try:
            stock = getattr(importlib.import_module(f"{package}.msg"), short)
        except ImportError:
            continue
        ours = from_definition(name, library.digests.full_text(library.message(name)))
        for seed in range(3):
            message = Values(seed).message(ours)
            copy = stock().deserialize(ours._encode(message))
            for options in ({"no_string": True}, {"no_array": True}, {"no_string": True, "no_array": True}):
                transform = create_value_transform(options.get("no_string", False), options.get("no_array", False))
                other = genpy.message.strify_message(transform(copy))
                mine = format_message(message, **options)
                if mine != other:
                    failures.append(f"{name} {options}: stock {other!r}, pyros1 {mine!r}")
        count["types"] += 1
    return {"count": count, "failures": failures[:10]}


def main(argv: list[str]) -> int:
    warnings.simplefilter("ignore")  # stock's own
    report = {
        "sums": sums,
        "values": lambda: values(int(argv[1])),
        "strings": lambda: strings(int(argv[1])),
        "hidden": hidden,
    }[argv[0]]()
    json.dump(report, sys.stdout)
    return 0


if __name__ == "__main__":
    assert python_name("from") == "from_"
    sys.exit(main(sys.argv[1:]))
