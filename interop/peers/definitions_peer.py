"""Compares pyros1's message classes with genmsg's and genpy's for random definitions; prints a JSON report.

Run with the Python that has the stock packages, and pyros1's source on PYTHONPATH::

    definitions_peer.py FIRST_SEED COUNT
"""

from __future__ import annotations

import json
import math
import random
import struct
import sys
import warnings
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import genmsg.gentools
import genmsg.msg_loader
import genpy
import genpy.dynamic
import numpy
from messages_peer import encode_stock, make_empty, one_value, to_stock

sys.path.insert(0, str(Path(__file__).resolve().parent.parent.parent / "tests" / "msgs"))
from random_definitions import Definition, random_definition, random_message

from pyros1.ground.errors import DeserializationError, MessageError
from pyros1.ground.timing import Duration, TVal
from pyros1.msgs.array_views import make_genpy_view
from pyros1.msgs.digest import Digests
from pyros1.msgs.dynamic import from_definition
from pyros1.msgs.factory import python_name
from pyros1.msgs.spec import parse_message

VIEW = make_genpy_view(numpy)
numpy.bool = bool  # genpy's code calls it so


def stock_classes(definition: Definition) -> dict[str, Any]:
    """Let genpy make the classes."""
    text = definition.full_text()
    before = list(sys.path)
    try:
        return dict(genpy.dynamic.generate_dynamic(definition.name, text))
    except IndexError:  # genpy cannot build a class from an empty text
        if text.strip():
            raise
        return {definition.name: make_empty(definition.name.partition("/")[2])}
    finally:
        sys.path[:] = before  # it leaves a folder there for each


def specs(definition: Definition) -> Iterator[str]:
    """Compare what genmsg makes of the texts; yield the differences."""
    context = genmsg.MsgContext.create_default()
    theirs = {
        name: genmsg.msg_loader.load_msg_from_string(context, text, name) for name, text in definition.texts.items()
    }
    for name, spec in theirs.items():
        context.register(name, spec)
    for spec in theirs.values():
        genmsg.msg_loader.load_depends(context, spec, {})
    ours = {name: parse_message(name, text) for name, text in definition.texts.items()}
    digests = Digests(ours.__getitem__)
    for name, other in theirs.items():
        mine = ours[name]
        pairs = {
            "types": (other.types, [field.type for field in mine.fields]),
            "names": (other.names, [field.name for field in mine.fields]),
            "header": (other.has_header(), mine.has_header),
            "constants": (
                [(c.type, c.name, c.val, c.val_text) for c in other.constants],
                [(c.type, c.name, c.value, c.text) for c in mine.constants],
            ),
            "md5": (genmsg.gentools.compute_md5(context, other), digests.md5(mine)),
            "full text": (genmsg.gentools.compute_full_text(context, other), digests.full_text(mine)),
        }
        for what, (theirs_is, mine_is) in pairs.items():
            if theirs_is != mine_is:
                yield f"{name} {what}: stock {theirs_is!r}, pyros1 {mine_is!r}"


def classes(definition: Definition, theirs: dict[str, Any], seed: int, count: Counter[str]) -> Iterator[str]:
    """Compare the classes: attributes, messages both ways, text, filling."""
    ours: Any = from_definition(definition.name, definition.full_text())
    stock = theirs[definition.name]
    for constant in parse_message(definition.name, definition.texts[definition.name]).constants:
        name = python_name(constant.name)
        mine, other = getattr(ours, name), getattr(stock, name)
        if (mine != other and not math.isnan(mine)) or type(mine) is not type(other):
            yield f"constant {name}: genpy {other!r}, pyros1 {mine!r}"
    if ours.__slots__ != stock.__slots__ or ours._slot_types != stock._slot_types:
        yield f"fields {ours.__slots__} {ours._slot_types}, genpy {stock.__slots__} {stock._slot_types}"
        return
    yield from one_value(ours, theirs, 0, count)
    yield from one_value(ours, theirs, seed + 1, count)
    message = random_message(random.Random(seed), ours)
    body, other_body = ours._encode(message), encode_stock(to_stock(message, theirs))
    if body != other_body:
        yield f"encodes to {body!r}, genpy's to {other_body!r}"
    yield from cut(ours, stock, message, random.Random(seed), count)
    yield from odd_times(ours, stock, message, random.Random(seed), count)


def times(message: Any) -> Iterator[Any]:
    """Yield the times and durations of a message, also those of its parts."""
    if isinstance(message, (TVal, genpy.TVal)):
        yield message
    elif hasattr(message, "_slot_types"):
        for name in message.__slots__:
            yield from times(getattr(message, name))
    elif isinstance(message, (list, tuple)):
        for element in message:
            yield from times(element)


def odd_times(ours: Any, stock: Any, message: Any, rng: random.Random, count: Counter[str]) -> Iterator[str]:
    """Compare what is received of times with any numbers of nanoseconds."""
    for time in times(message):
        signed = isinstance(time, Duration)
        time.secs, time.nsecs = struct.unpack("<2i" if signed else "<2I", rng.randbytes(8))
    count["times"] += len(list(times(message)))
    data = ours._encode(message)
    results = {
        "decoded": (ours._decode(data, 0, len(data)), stock().deserialize(data)),
        "with numpy": (ours._decode_arrays(data, 0, len(data), VIEW), stock().deserialize_numpy(data, numpy)),
        "copied": (ours._copy(message), stock().deserialize(data)),
    }
    for what, pair in results.items():
        mine, other = ([(time.secs, time.nsecs) for time in times(decoded)] for decoded in pair)
        if mine != other:
            yield f"times {what}: {mine!r}, genpy's {other!r}"


def cut(ours: Any, stock: Any, message: Any, rng: random.Random, count: Counter[str]) -> Iterator[str]:
    """Compare what is received of messages that lack bytes at their end."""
    whole = ours._encode(message)
    for size in {*rng.sample(range(len(whole)), min(len(whole), 5)), *range(max(len(whole) - 4, 0), len(whole))}:
        data = whole[:size]
        try:
            other = str(stock().deserialize(data))
        except genpy.DeserializationError:
            other = "an error"
        try:
            mine = str(ours._decode(data, 0, size))
        except DeserializationError:
            mine = "an error"
        count["cut and received"] += other != "an error"
        if mine != other:
            yield f"{data.hex()}, cut off from {whole.hex()}: {mine}, genpy {other}"


def in_code_of_genpy(error: BaseException) -> bool:
    """Whether code that genpy has generated has raised an exception."""
    place = error.__traceback__
    while place is not None and place.tb_next is not None:
        place = place.tb_next
    return place is not None and "/genpy_" in place.tb_frame.f_code.co_filename


def report(seeds: range) -> dict[str, Any]:
    """Compare many definitions."""
    failures: list[str] = []
    count: Counter[str] = Counter()
    for seed in seeds:
        definition = random_definition(random.Random(seed))
        count["definitions"] += 1
        try:
            theirs = stock_classes(definition)
        except Exception as error:  # noqa: BLE001  genpy raises anything
            count[f"refused by genpy: {type(error).__name__}"] += 1
            continue
        try:
            problems = [*specs(definition), *classes(definition, theirs, seed, count)]
        except MessageError as error:
            problems = [f"pyros1 refuses it: {error}"]
        except AttributeError as error:
            if not in_code_of_genpy(error):
                raise
            count["genpy's code does not run"] += 1  # it looks for `each.self` where the field is `each.self_`
            continue
        failures += [f"seed {seed}: {problem[:500]}" for problem in problems[:2]]
    return {"count": count, "failures": failures}


if __name__ == "__main__":
    warnings.simplefilter("ignore")  # stock's own
    first, number = map(int, sys.argv[1:])
    json.dump(report(range(first, first + number)), sys.stdout)
