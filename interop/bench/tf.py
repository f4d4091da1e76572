"""Lookups and insertions per second of tf2_py.BufferCore: stock's C++ extension and ours, from one Python program.

::

    python interop/bench/tf.py [SECONDS]

prints a table. A chain has 1, 5 or 10 frames; dynamic frames have ten seconds of transforms at 100 Hz. *latest* asks at
time 0, *timed* between two transforms, so that each frame is interpolated, again and again at the same time, *moving*
at another time in each call; *can* asks whether there is a transform.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2] / "src"
STOCK_PYTHON = "/usr/bin/python3"
ROUNDS = 3

PROGRAM = """
import json, math, sys
from time import process_time  # other programs run, too
import rospy, tf2_py
from geometry_msgs.msg import TransformStamped

SPAN = float(sys.argv[1])

def stamped(parent, child, ns, x=0.0):
    it = TransformStamped()
    it.header.frame_id, it.child_frame_id, it.header.stamp = parent, child, rospy.Time(*divmod(ns, 10**9))
    it.transform.translation.x = x
    it.transform.rotation.z, it.transform.rotation.w = math.sin(x), math.cos(x)
    return it

def rate(ask, target, source, *times):
    count, start = 0, process_time()
    while process_time() - start < SPAN:
        for time in times:
            ask(target, source, time)
        count += 100
    return count / (process_time() - start)

def filled(length, static):
    core = tf2_py.BufferCore(rospy.Duration(10.0))
    for level in range(length):
        for step in range(1000):
            it = stamped("f%d" % level, "f%d" % (level + 1), 10**11 + step * 10**7, 0.001 * step)
            if static:
                core.set_transform_static(it, "bench")
                break
            core.set_transform(it, "bench")
    return core

rows = {}
latest, timed = 100 * [rospy.Time(0)], 100 * [rospy.Time(105, 5000000)]
moving = [rospy.Time(105, 5000000 + 9000000 * step) for step in range(100)]
for static in (True, False):
    for length in (1, 5, 10):
        core, tip = filled(length, static), "f%d" % length
        name = "%s, %d" % ("static" if static else "dynamic", length)
        rows["lookup latest, " + name] = rate(core.lookup_transform_core, "f0", tip, *latest)
        rows["lookup timed, " + name] = rate(core.lookup_transform_core, "f0", tip, *timed)
        rows["lookup moving, " + name] = rate(core.lookup_transform_core, "f0", tip, *moving)
        rows["can timed, " + name] = rate(core.can_transform_core, "f0", tip, *timed)
core = tf2_py.BufferCore(rospy.Duration(10.0))
messages = [stamped("a", "b", 10**11 + step * 10**6) for step in range(30000)]
start = process_time()
for it in messages:
    core.set_transform(it, "bench")
rows["insert, 1 kHz, a cache of 10 s"] = len(messages) / (process_time() - start)
print(json.dumps(rows))
"""


def measure(face: str, span: str) -> dict[str, float]:
    """Return calls per second of each row, for ``stock`` or ``ours``."""
    python, path = STOCK_PYTHON, ""
    if face == "ours":
        python, path = sys.executable, f"{SOURCE / 'pyros1' / 'drop_in' / 'start'}{os.pathsep}{SOURCE}"
    done = subprocess.run(
        [python, "-c", PROGRAM, span],
        env={"PATH": os.environ["PATH"], "PYTHONPATH": path},
        capture_output=True,
        text=True,
        timeout=600,
        check=True,
    )
    rows: dict[str, float] = json.loads(done.stdout)
    return rows


def main() -> None:
    """Measure both faces in turns, and print the best of each row."""
    span = sys.argv[1] if len(sys.argv) > 1 else "0.2"
    best: dict[str, dict[str, float]] = {"stock": {}, "ours": {}}
    for _ in range(ROUNDS):
        for face, rows in best.items():
            for name, value in measure(face, span).items():
                rows[name] = max(value, rows.get(name, 0.0))
    print("| tf2_py.BufferCore, per second | C++ | pyros1 | share |\n|---|---|---|---|")
    for name, stock in best["stock"].items():
        print(f"| {name} | {stock:,.0f} | {best['ours'][name]:,.0f} | {best['ours'][name] / stock:.2f} |")


if __name__ == "__main__":
    main()
