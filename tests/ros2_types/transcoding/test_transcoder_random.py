"""Random types and values against a slow codec, and damaged messages."""

from __future__ import annotations

import random

import pytest
from reference_codec import TypePair, Writer

from pyros1.ground.errors import MessageError
from pyros1.ros2_types.mapping import FieldRule
from pyros1.ros2_types.transcoding.fields import partners
from pyros1.ros2_types.transcoding.transcoder import Transcoder


def _make(seed: int) -> tuple[TypePair, Transcoder]:
    pair = TypePair(random.Random(seed))
    name = pair.root.name
    return pair, Transcoder(f"x/{name}", pair.specs, f"x/msg/{name}", pair.types)


@pytest.mark.slow
@pytest.mark.parametrize("block", range(10))
def test_random_messages(block: int) -> None:
    for seed in range(block * 20, block * 20 + 20):
        pair, transcoder = _make(seed)
        for _ in range(4):
            value = pair.value(1)
            body = Writer(1).message(pair.root, value)
            cdr = Writer(2).message(pair.root, value)
            assert transcoder.to_cdr(body) == cdr, seed
            assert transcoder.to_cdr(memoryview(body + b"surplus")) == cdr, seed
            value = pair.value(2)
            body = Writer(1).message(pair.root, value)
            for order in "<>":
                cdr = Writer(2, order, filler=0xA5).message(pair.root, value)
                assert transcoder.from_cdr(cdr) == body, (seed, order)
                assert transcoder.from_cdr(memoryview(cdr + b"\0\0\0")) == body, (seed, order)


@pytest.mark.slow
def test_fields_with_other_names() -> None:
    for seed in range(60):
        pair, transcoder = _make(seed)
        types = {
            name: each
            if [field.name for field in each.fields] == ["sec", "nanosec"]
            else each._replace(fields=tuple(field._replace(name=f"new_{field.name}") for field in each.fields))
            for name, each in pair.types.items()
        }
        rules = {}
        for spec in pair.specs.values():
            for each in pair.types.values():
                found = partners(*({field.name: None for field in one.fields} for one in (spec, each)))
                rules[spec.name, each.name] = FieldRule({name: f"new_{other}" for name, other in found.items()})
        name = pair.root.name
        renamed = Transcoder(f"x/{name}", pair.specs, f"x/msg/{name}", types, rules)
        body = Writer(1).message(pair.root, pair.value(1))
        assert renamed.to_cdr(body) == transcoder.to_cdr(body), seed
        cdr = Writer(2).message(pair.root, pair.value(2))
        assert renamed.from_cdr(cdr, 1) == transcoder.from_cdr(cdr, 1), seed
        assert renamed.only_ros1 == transcoder.only_ros1


@pytest.mark.slow
def test_truncated_messages_are_refused() -> None:
    for seed in range(25):
        pair, transcoder = _make(seed)
        body = Writer(1).message(pair.root, pair.value(1))
        for size in range(len(body))[-200:]:
            with pytest.raises(MessageError):
                transcoder.to_cdr(body[:size])
        for order in "<>":
            cdr = Writer(2, order).message(pair.root, pair.value(2))
            for size in range(len(cdr))[-200:]:
                with pytest.raises(MessageError):
                    transcoder.from_cdr(cdr[:size])


@pytest.mark.slow
def test_damaged_messages_are_converted_or_refused() -> None:
    randoms = random.Random(1)
    for seed in range(40):
        pair, transcoder = _make(seed)
        for convert, message in (
            (transcoder.to_cdr, Writer(1).message(pair.root, pair.value(1))),
            (transcoder.from_cdr, Writer(2).message(pair.root, pair.value(2))),
            (transcoder.from_cdr, Writer(2, ">").message(pair.root, pair.value(2))),
        ):
            for _ in range(30):
                damaged = bytearray(message)
                for _ in range(randoms.randrange(1, 4)):
                    if damaged:
                        damaged[randoms.randrange(len(damaged))] = randoms.choice([0, 1, 0x7F, 0xFF])
                try:
                    result = convert(bytes(damaged))
                except MessageError:
                    continue
                assert len(result) < 100_000
