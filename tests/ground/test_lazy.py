"""Modules that are imported when they are needed."""

from __future__ import annotations

import subprocess
import sys
from importlib import import_module
from types import ModuleType

import pytest

from pyros1.ground import lazy

EXIT_INTERRUPTED = """
import signal, sys
from pyros1.ground import lazy

wanted = lazy.import_without_lock("pyros1.ground.timing")
count = 0

def handle(*_):
    global count
    count += 1
    assert lazy.import_without_lock("pyros1.ground.timing") is wanted
    again = (30e-6, 0.01) if count < 3000 else (0,)  # the second one in case that the interpreter misses the first
    signal.setitimer(signal.ITIMER_REAL, *again)

signal.signal(signal.SIGALRM, handle)
signal.setitimer(signal.ITIMER_REAL, 30e-6)
while count < 3000:
    assert lazy.import_without_lock("pyros1.ground.timing") is wanted
print(count)
"""


def test_the_module_itself_comes() -> None:
    for name in ("pyros1.ground.timing", "pyros1.msgs", "pyros1", "sys"):
        found = lazy.import_without_lock(name)
        assert isinstance(found, ModuleType)
        assert found is import_module(name)


def test_nothing_more_is_imported() -> None:
    code = (
        "import sys; from pyros1.ground import lazy; lazy.import_without_lock('pyros1'); "
        "print('pyros1.node' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout == "False\n"


def test_a_missing_module() -> None:
    with pytest.raises(ModuleNotFoundError, match="no_such_one"):
        lazy.import_without_lock("pyros1.ground.no_such_one")


def test_a_signal_handler_may_import_what_the_main_thread_imports() -> None:
    done = subprocess.run(
        [sys.executable, "-c", EXIT_INTERRUPTED], capture_output=True, text=True, check=False, timeout=60
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "3000\n", "")
