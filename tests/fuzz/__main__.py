"""The fuzz program: ``python -m tests.fuzz NAME [--seconds 60]``, from the project's folder.

With atheris (``pip install atheris``) it is guided by coverage; without it, inputs are changed at random. An input that
breaks the contract ends it. Put that input into the fuzzer's corpus, with a remark, when what it found is mended.
"""

from __future__ import annotations

import argparse
import contextlib
import random
import resource
import sys
import tempfile
import time
import tracemalloc
import warnings
from importlib import import_module
from pathlib import Path
from typing import Any

ROOM = 2 << 30
"""Most bytes of the address space beyond what the program has at its beginning."""


def main() -> None:
    """Run a fuzzer for some time."""
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description=(__doc__ or "").split("\n\n")[1])
    parser.add_argument("name", help="of the fuzzer; 'list' shows them")
    parser.add_argument("--seconds", type=int, default=60)
    parser.add_argument("--folder", type=Path, help="where inputs with new coverage are kept, with atheris")
    parser.add_argument("--random", action="store_true", help="without atheris")
    options = parser.parse_args()
    try:
        atheris: Any = None if options.random else import_module("atheris")
    except ImportError:
        atheris = None
    with atheris.instrument_imports(include=["pyros1"]) if atheris else contextlib.nullcontext():
        from .fuzzers import FUZZERS
    if options.name not in FUZZERS:
        sys.exit("\n".join(FUZZERS) if options.name == "list" else f"no fuzzer {options.name!r}; see 'list'")
    warnings.simplefilter("ignore", UnicodeWarning)  # what is not UTF-8 is replaced, and a warning says so
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    if atheris:
        _guided(atheris, options.name, options.seconds, options.folder)
    else:
        used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (used + ROOM, used + ROOM))
        _random(options.name, options.seconds)


def _random(name: str, seconds: int) -> None:
    from .fuzzer import check, inputs, mutations
    from .fuzzers import FUZZERS

    fuzzer = FUZZERS[name]
    seed = random.randrange(1 << 32)
    known = inputs(name, fuzzer)
    count, until = 0, time.monotonic() + seconds
    tracemalloc.start()
    for data in mutations(fuzzer, known, random.Random(seed)):
        count += 1
        if check(fuzzer, data) and len(known) < 2000 and data not in known:
            known.append(data)
        if time.monotonic() > until:
            break
    print(f"{name}: {count} inputs, {len(known)} taken (seed {seed})")


def _guided(atheris: Any, name: str, seconds: int, folder: Path | None) -> None:
    from .fuzzer import check, inputs
    from .fuzzers import FUZZERS

    fuzzer = FUZZERS[name]
    with tempfile.TemporaryDirectory() as made:
        place = Path(folder or made)
        place.mkdir(parents=True, exist_ok=True)
        for number, data in enumerate(inputs(name, fuzzer)):
            (place / f"seed{number}").write_bytes(data)
        words = Path(made) / "words.dict"
        words.write_text("".join(f'"{_escaped(word)}"\n' for word in fuzzer.words))
        (Path(made) / "corpus").mkdir()
        limits = [f"-max_total_time={seconds}", f"-max_len={fuzzer.largest}", "-timeout=300", "-rss_limit_mb=2048"]
        found = f"-artifact_prefix={place.parent}/{name}-"
        atheris.Setup(
            ["fuzz", *limits, found, f"-dict={words}", "-print_final_stats=1", "-verbosity=0", str(place)],
            lambda data: check(fuzzer, data, memory=False) and None,
        )
        atheris.Fuzz()


def _escaped(word: bytes) -> str:
    return "".join(chr(byte) if 32 <= byte < 127 and byte not in b'"\\' else f"\\x{byte:02x}" for byte in word)


if __name__ == "__main__":
    main()
