"""What a fuzzer is, what it checks of each input, and how inputs are changed at random.

A reader of bytes from elsewhere has one contract: any bytes give a value or one of its documented errors, in bounded
time and memory. A fuzzer hands bytes to such a reader and checks this, and whatever else must hold of the result.
"""

from __future__ import annotations

import ast
import random
import re
import time
import tracemalloc
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

CORPUS = Path(__file__).parent / "corpus"
MEGABYTE = 1 << 20
SLOWEST = 5.0
"""Seconds of the processor's time that an input may take, on a slow machine and with the memory traced."""
_NUMBERS = (0, 1, 2, 3, 7, 8, 127, 128, 255, 256, 1000, 65535, 65536, 1 << 20, 1 << 24, (1 << 31) - 1, 1 << 31)
_NUMBERS += ((1 << 32) - 1, (1 << 32) - 4, 1 << 32, (1 << 63) - 1, 1 << 63, (1 << 64) - 1)


@dataclass(frozen=True)
class Fuzzer:
    """A reader, and what is known of it.

    Attributes:
        run: hands an input to the reader, and checks the result.
        errors: the documented errors.
        words: pieces of which its inputs consist.
        seeds: makes inputs, in addition to those of the corpus.
        largest: most bytes of a random input.
        memory: most bytes that an input may take.
    """

    run: Callable[[bytes], object]
    errors: tuple[type[Exception], ...] = ()
    words: Sequence[bytes] = ()
    seeds: Callable[[], Sequence[bytes]] = tuple
    largest: int = 4096
    memory: int = 16 * MEGABYTE


def words(text: str) -> list[bytes]:
    """Return words that are written with two spaces or a line break between them, and with Python's escapes."""
    found = [word for word in re.split(r" {2,}|\n *", text.strip()) if word]
    return [word.encode("ascii").decode("unicode_escape").encode("latin-1") for word in found]


class Finding(Exception):
    """An input for which the contract does not hold."""


def check(fuzzer: Fuzzer, data: bytes, *, memory: bool = True) -> bool:
    """Hand an input to a reader.

    Args:
        fuzzer: the reader.
        data: the input.
        memory: whether to check the memory, too; `tracemalloc` must be on.

    Returns:
        Whether the reader took it.

    Raises:
        Finding: the reader raised another error than documented, took too much, or gave a wrong result.
    """
    begin = time.process_time()
    if memory:
        before = tracemalloc.get_traced_memory()[0]
        tracemalloc.reset_peak()
    taken = True
    try:
        fuzzer.run(data)
    except fuzzer.errors:
        taken = False
    except Exception as error:
        raise Finding(f"{type(error).__name__}: {error}\ninput: {_shown(data)}") from error
    spent = time.process_time() - begin
    if spent > SLOWEST:
        raise Finding(f"{spent:.1f} s\ninput: {_shown(data)}")
    if memory:
        size = tracemalloc.get_traced_memory()[1] - before
        if size > fuzzer.memory:
            raise Finding(f"{size} bytes of memory\ninput: {_shown(data)}")
    return taken


def _shown(data: bytes) -> str:
    return repr(data) if len(data) <= 2000 else f"{data[:2000]!r}... ({len(data)} bytes)"


def read_corpus(name: str) -> list[bytes]:
    """Return the inputs of a corpus: one per line, as Python writes bytes. Lines that begin with # are remarks."""
    path = CORPUS / f"{name}.txt"
    lines = path.read_text(encoding="ascii").splitlines() if path.exists() else []
    return [ast.literal_eval(line) for line in lines if line and not line.startswith("#")]


def inputs(name: str, fuzzer: Fuzzer) -> list[bytes]:
    """Return the inputs to begin with."""
    return [*read_corpus(name), *fuzzer.seeds()] or [b""]


def mutations(fuzzer: Fuzzer, known: Sequence[bytes], chance: random.Random) -> Iterator[bytes]:
    """Yield inputs that are like known ones, without end.

    Args:
        fuzzer: says of which words inputs consist, and how large they may be.
        known: the inputs to change; it may grow.
        chance: decides.
    """
    while True:
        data = bytearray(chance.choice(known))
        for _ in range(chance.choice((1, 1, 2, 3, 8))):
            _change(data, fuzzer.words, known, chance)
        yield bytes(data[: fuzzer.largest])


def _change(data: bytearray, words: Sequence[bytes], known: Sequence[bytes], chance: random.Random) -> None:
    """Change one thing."""
    at = chance.randint(0, len(data))
    end = min(len(data), at + chance.choice((1, 1, 4, 16, 64)))
    match chance.randrange(9):
        case 0:
            data[at:end] = b""
        case 1:
            data[at:end] = chance.randbytes(end - at)
        case 2 if at < len(data):
            data[at] ^= 1 << chance.randrange(8)
        case 3:
            data[at:at] = data[at:end] * chance.choice((1, 2, 20, 300))
        case 4 | 5 if words:
            data[at : chance.choice((at, end))] = chance.choice(words) * chance.choice((1, 1, 1, 1, 2, 100))
        case 6:  # a number in binary
            size = chance.choice((1, 2, 4, 8))
            number = chance.choice(_NUMBERS) & ((1 << 8 * size) - 1)
            data[at : at + size] = number.to_bytes(size, chance.choice(("little", "big")))
        case 7:  # a number in digits
            data[at:end] = b"%d" % (chance.choice((1, -1)) * chance.choice(_NUMBERS))
        case _:
            other = chance.choice(known)
            start = chance.randint(0, len(other))
            data[at : chance.choice((at, end, len(data)))] = other[start : start + chance.choice((4, 32, 4096))]
