"""``import pyros1`` changes nothing in the process of the program that imports it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

SOURCES = Path(__file__).resolve().parents[1] / "src"

PROGRAM = """
import atexit, codecs, gc, importlib, logging, os, signal, sys, threading, warnings

registered = []
atexit.register = lambda function, *words, **named: registered.append(function)

def state():
    return {
        "hooks": (sys.excepthook, sys.unraisablehook, threading.excepthook, sys.displayhook, sys.gettrace()),
        "finders": (list(sys.meta_path), list(sys.path_hooks), list(sys.path)),
        "signals": {each: signal.getsignal(each) for each in signal.valid_signals()},
        "exit": list(registered),
        "warnings": (list(warnings.filters), warnings.showwarning, warnings.formatwarning),
        "environment": (dict(os.environ), os.getcwd(), list(sys.argv), os.umask(os.umask(0o22))),
        "streams": (sys.stdin, sys.stdout, sys.stderr),
        "threads": threading.enumerate(),
        "interpreter": (sys.getswitchinterval(), sys.getrecursionlimit(), gc.isenabled(), gc.get_threshold()),
        "logging": (logging.getLogger().handlers, logging.getLogger().level, logging.getLoggerClass()),
        "encodings": is_known("pyros1"),
    }

def is_known(error_handler):
    try:
        return codecs.lookup_error(error_handler)
    except LookupError:
        return None

before = state()
for name in sys.argv[1:]:
    importlib.import_module(name)
after = state()
print([what for what in before if before[what] != after[what]])
"""
NOT_LIBRARIES = {"README", "__main__", "__pycache__", "drop_in", "packages", "py"}
"""What programs do not import from pyros1; `drop_in` is for finding modules under stock's names."""


def run(program: str, *words: str) -> bytes:
    """Return what a program prints in a fresh interpreter."""
    return subprocess.run(
        [sys.executable, "-c", program, *words], env={**os.environ, "PYTHONPATH": str(SOURCES)}, stdout=subprocess.PIPE,
        timeout=60, check=True,
    ).stdout  # fmt: skip


def changed(*modules: str) -> str:
    """Return what is different in a fresh process after the import of modules."""
    return run(PROGRAM, *modules).decode()


def test_importing_pyros1_changes_nothing() -> None:
    """Feature: `import pyros1` changes nothing in the process -- no hooks, finders, signal handlers, threads or
    warnings; Node and the commands install what they need
    """
    assert changed("pyros1", "pyros1.ground.timing", "pyros1.wire.framing") == "[]\n"


def test_importing_any_room_changes_nothing() -> None:
    rooms = [path.stem for path in (SOURCES / "pyros1").iterdir() if path.stem not in NOT_LIBRARIES]
    assert len(rooms) > 20
    assert changed(*(f"pyros1.{room}" for room in sorted(rooms))) == "[]\n"


def test_messages_are_imported_as_any_modules(tmp_path: Path) -> None:
    """Any form of import; pickles from another process; reloads; caches that a program discards."""
    (tmp_path / "twist").write_bytes(
        run(
            """
import pickle, sys
from pyros1.msgs.geometry_msgs.msg import Twist, Vector3
sys.stdout.buffer.write(pickle.dumps(Twist(Vector3(1, 2, 3), Vector3())))
"""
        )
    )
    program = """
import importlib, importlib.util, pickle, pkgutil, sys
twist = pickle.load(open(sys.argv[1], "rb"))
assert twist.linear.y == 2 and type(twist).__module__ == "pyros1.msgs.geometry_msgs.msg"
import pyros1.msgs.geometry_msgs as package
assert package.msg.Twist is type(twist)
from pyros1.msgs import std_msgs, std_srvs
from pyros1.msgs.std_msgs import msg
from pyros1.msgs.std_msgs.msg import String
importlib.invalidate_caches()
sys.path_importer_cache.clear()
import pyros1.msgs.nav_msgs.msg, pyros1.msgs.std_srvs.srv as services
assert services.Empty and pyros1.msgs.nav_msgs.msg.Odometry
assert importlib.reload(msg) is msg and msg.String is String
importlib.reload(std_msgs)
importlib.reload(pyros1.msgs)
import pyros1.msgs.tf2_msgs.msg
assert pyros1.msgs.load_message("std_msgs/String") is String
assert importlib.util.find_spec("pyros1.msgs.rosgraph_msgs.msg")
assert "base" in [each.name for each in pkgutil.iter_modules(pyros1.msgs.__path__)]
print(len([each for each in sys.path_importer_cache.values() if "msgs_imports" in type(each).__module__]))
"""
    assert run(program, str(tmp_path / "twist")) == b"1\n"


def test_messages_are_found_while_another_thread_imports_their_package(tmp_path: Path) -> None:
    """Python puts a package into sys.modules before its code has run, and other threads see it with its first path."""
    program = """
import os, sys
import pyros1.msgs
pyros1.msgs.__path__ = [os.path.dirname(pyros1.msgs.__file__)]
import pyros1.msgs.base
from pyros1.msgs.std_msgs.msg import String
from pyros1.msgs import geometry_msgs
print(String._type, type(geometry_msgs.__path__).__name__)
"""
    assert run(program) == b"std_msgs/String SearchPath\n"


def test_threads_that_import_at_once() -> None:
    program = """
import importlib, threading
barrier, classes, packages = threading.Barrier(8), [], ("std_msgs", "geometry_msgs")

def load(number):
    barrier.wait(10)
    importlib.import_module(f"pyros1.msgs.{packages[number % 2]}.msg")
    classes.append(importlib.import_module("pyros1.msgs.std_msgs.msg").String)

threads = [threading.Thread(target=load, args=(number,)) for number in range(8)]
[each.start() for each in threads]
[each.join() for each in threads]
print(len(classes), len(set(classes)))
"""
    assert run(program) == b"8 1\n"
