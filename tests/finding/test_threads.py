"""Threads that import messages for the first time, all at once: none waits for ever, all get the same classes."""

from __future__ import annotations

import subprocess
import sys

import pytest

CODE = """
import faulthandler, sys, threading
import pyros1
faulthandler.dump_traceback_later(30, exit=True)
start, made = threading.Barrier(3), []

def one():
    start.wait()
    from pyros1.msgs.geometry_msgs.msg import Twist, Vector3
    made.append(Vector3)

def two():
    start.wait()
    from pyros1.msgs.std_msgs.msg import Float64
    made.append(Float64)

def three():
    start.wait()
    from pyros1.msgs import load_message
    made.append(load_message("geometry_msgs/Vector3"))

threads = [threading.Thread(target=work) for work in (one, two, three)]
for thread in threads:
    thread.start()
for thread in threads:
    thread.join()
assert len(made) == 3 and len({*made}) == 2, made
"""


@pytest.mark.parametrize("attempt", range(10))
def test_first_imports_on_several_threads(attempt: int) -> None:
    subprocess.run([sys.executable, "-c", CODE], check=True, timeout=60)
