"""What definitions of others may cost: time and memory in proportion to their length, whatever they say.

Feature: a definition takes memory in proportion to its length -- whatever it contains
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.once

PROGRAM = """
import resource, sys
from pyros1.msgs import from_definition
import pyros1.msgs.check, pyros1.msgs.constructor, pyros1.msgs.copier, pyros1.msgs.decoder, pyros1.msgs.encoder
sys.path.insert(0, {folder!r})
import codec
from test_memory import {maker}

text = {maker}()
used = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (used + {megabytes} * 2**20,) * 2)
cls = from_definition("p/T", text)
body = codec.encode(cls())
assert codec.copy(codec.decode(cls, body, 0, len(body))) == cls()
print(len(text))
"""
SEPARATOR = "=" * 80


def large_type_in_many() -> str:
    """4,500 types that hold one whose text is half of all: if each kept its full text, these would be 2.5 GB."""
    users = range(4500)
    parts = [f"U{i} u{i}\n" for i in users]
    parts += [f"{SEPARATOR}\nMSG: p/U{i}\nH h\n" for i in users]
    return "".join(parts) + f"{SEPARATOR}\nMSG: p/H\nint8 x\n#" + "-" * (1 << 19)


def many_fields() -> str:
    """6,000 fields of every kind."""
    kinds = ["int8", "string", "time", "float64[]", "string[]", "P", "P[]", "uint8[3]"]
    fields = "".join(f"{kinds[i % len(kinds)]} f{i}\n" for i in range(6000))
    return f"{fields}{SEPARATOR}\nMSG: p/P\nfloat64 x\ntime t"


def deep_and_wide() -> str:
    """Types of 40 levels, each of which holds the next one twice in arrays."""
    levels = [f"{SEPARATOR}\nMSG: p/L{i}\nL{i + 1}[] a\nL{i + 1}[] b\n#{'-' * 20_000}\n" for i in range(40)]
    return "L0[] x\n" + "".join(levels) + f"{SEPARATOR}\nMSG: p/L40\nint8 x"


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="needs the address space that the process has")
@pytest.mark.parametrize(("maker", "megabytes"), [(large_type_in_many, 64), (many_fields, 48), (deep_and_wide, 32)])
def test_a_definition_takes_memory_in_proportion(maker: object, megabytes: int) -> None:
    program = PROGRAM.format(folder=str(Path(__file__).parent), maker=maker.__name__, megabytes=megabytes)  # type: ignore[attr-defined]
    done = subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
        stdin=subprocess.DEVNULL,
    )
    assert done.returncode == 0, done.stderr[-500:]
