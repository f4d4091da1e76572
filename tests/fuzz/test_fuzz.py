"""Any bytes give a value or a documented error, in bounded time and memory: each fuzzer, for a moment.

``python -m tests.fuzz NAME`` runs one for longer, guided by coverage if atheris is installed.

Feature: any bytes give a value or a documented error, in bounded time and memory -- everything that reads data from
    outside is fuzzed
"""

from __future__ import annotations

import random
import time
import tracemalloc
from collections.abc import Iterator
from pathlib import Path

import pytest

from .fuzzer import CORPUS, Finding, Fuzzer, check, inputs, mutations, read_corpus
from .fuzzers import FUZZERS

pytestmark = pytest.mark.once

MOMENT = 0.15
"""Seconds of the processor's time for inputs that are made at random."""


@pytest.fixture
def traced() -> Iterator[None]:
    """Count memory."""
    tracemalloc.start()
    yield
    tracemalloc.stop()


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::UnicodeWarning")  # what is not UTF-8 is replaced, and a warning says so
@pytest.mark.parametrize("name", FUZZERS)
def test_any_bytes_give_a_value_or_a_documented_error(name: str, traced: None) -> None:
    fuzzer = FUZZERS[name]
    known = inputs(name, fuzzer)
    taken = [check(fuzzer, data) for data in known]
    assert any(taken), "no input is taken: the fuzzer tests nothing"
    until = time.process_time() + MOMENT
    for data in mutations(fuzzer, known, random.Random()):
        check(fuzzer, data)
        if time.process_time() > until:
            break


def test_each_corpus_has_its_fuzzer() -> None:
    assert {path.stem for path in CORPUS.iterdir()} <= FUZZERS.keys()


@pytest.mark.parametrize("path", sorted(CORPUS.iterdir()), ids=lambda path: path.stem)
def test_corpora_are_small(path: Path) -> None:
    assert path.stat().st_size < 50_000 and len(read_corpus(path.stem)) <= 25


def _take(data: bytes) -> None:
    match data:
        case b"wrong":
            raise KeyError("x")
        case b"large":
            bytes(1 << 24)
        case b"known":
            raise ValueError


@pytest.mark.parametrize(
    ("data", "reason"), [(b"wrong", "KeyError: 'x'\ninput: b'wrong'"), (b"large", "bytes of memory")]
)
def test_what_breaks_the_contract_is_found(data: bytes, reason: str, traced: None) -> None:
    fuzzer = Fuzzer(_take, (ValueError,), memory=1 << 20)
    assert check(fuzzer, b"") and not check(fuzzer, b"known")
    with pytest.raises(Finding, match=reason):
        check(fuzzer, data)


def test_inputs_are_changed_within_their_size() -> None:
    fuzzer = Fuzzer(_take, words=[b"word"], largest=50)
    made = mutations(fuzzer, [b"abc", b"defghi"], random.Random(1))
    found = {next(made) for _ in range(500)}
    assert len(found) > 300 and max(map(len, found)) == 50
    assert any(b"word" in data for data in found)
