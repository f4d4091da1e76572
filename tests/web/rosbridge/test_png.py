"""Frames as PNG images."""

from __future__ import annotations

import base64
import json
import random
import zlib

import pytest

pytest.importorskip("PIL")

from pyros1.web.rosbridge.png import pack, unpack


def frame(data: bytes) -> str:
    return json.dumps({"op": "publish", "data": base64.b64encode(data).decode()})


NOISE = random.Random(1).randbytes(100_000)


@pytest.mark.parametrize(
    "data",
    [b"", b"a", bytes(100_000), NOISE, bytes(50_000) + NOISE, *(NOISE[:size] for size in range(12_280, 12_300))],
)
def test_images_can_be_read(data: bytes) -> None:
    assert json.loads(unpack(pack(frame(data)), 1 << 20)) == json.loads(frame(data))


def test_repetitions_are_found_and_noise_is_not_searched_for_them(monkeypatch: pytest.MonkeyPatch) -> None:
    assert len(base64.b64decode(pack(frame(bytes(100_000))))) < 3_000
    for mixed in (bytes(150_000) + NOISE, NOISE + bytes(150_000)):
        assert len(base64.b64decode(pack(frame(mixed)))) < 150_000
    strategies = []
    compressobj = zlib.compressobj

    def record(level: int, *, strategy: int) -> object:
        strategies.append(strategy)
        return compressobj(level, strategy=strategy)

    monkeypatch.setattr(zlib, "compressobj", record)
    # base64 needs 6 bits of each byte.
    assert len(base64.b64decode(pack(frame(NOISE)))) < 1.02 * len(NOISE)
    assert strategies[-1] == zlib.Z_HUFFMAN_ONLY
