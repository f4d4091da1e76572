"""The machine's clock is set back by an hour and forth by two: nodes, timeouts, recordings and the master go on."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from faces import start
from harness import SOURCE, Master, until

from pyros1.bag.format.reader import BagReader

MASTERS = ("ours",)
HOUR = 3600.0
OFFSET = """
import time
_real, _real_ns = time.time, time.time_ns
def _offset():
    with open({path!r}) as file:
        return float(file.read() or 0)
time.time = lambda: _real() + _offset()
time.time_ns = lambda: _real_ns() + int(_offset() * 1e9)
"""
PROGRAM = """
import threading, rospy
from std_msgs.msg import Float64
rospy.init_node("clocked")
rospy.Timer(rospy.Duration(0.05), lambda event: print("timer", flush=True))
def loop(what, once):
    def run():
        while not rospy.is_shutdown():
            once()
            print(what, flush=True)
    threading.Thread(target=run, daemon=True).start()
def late(wait):
    def once():
        try:
            wait()
        except rospy.ROSException:
            pass
    return once
rate = rospy.Rate(20)
publisher = rospy.Publisher("/ticks", Float64, queue_size=10)
loop("rate", rate.sleep)
loop("sleep", lambda: (rospy.sleep(0.05), publisher.publish(1.0), rospy.logwarn_throttle(0.2, "throttled")))
loop("service", late(lambda: rospy.wait_for_service("/none", 0.1)))
loop("message", late(lambda: rospy.wait_for_message("/none", Float64, 0.1)))
print("ready", flush=True)
rospy.spin()
"""
ALL = ("timer", "rate", "sleep", "service", "message", "throttled")


class Clock:
    """The clock of programs that run the text of its module, or find it in its folder."""

    def __init__(self, folder: Path) -> None:
        self._file = folder / "offset"
        self.set(0.0)
        self.module = OFFSET.format(path=str(self._file))
        (folder / "sitecustomize.py").write_text(self.module)

    def set(self, seconds: float) -> None:
        aside = self._file.with_suffix(".new")
        aside.write_text(str(seconds))
        aside.replace(self._file)


@pytest.mark.parametrize("face", ["ours", "stock"])
def test_a_rospy_program(launcher: Master, tmp_path: Path, face: str) -> None:
    clock = Clock(tmp_path)
    program = start(face, launcher, clock.module + PROGRAM)
    program.wait_line("^ready$", 20)
    for offset in (0.0, -HOUR, HOUR):
        clock.set(offset)
        del program.lines[:]
        for _ in range(4):
            # Stock's messages and services stand still after some jumps.
            for what in ALL if face == "ours" else ALL[:3]:
                program.wait_line(what, 20)


def test_a_core_a_recorder_and_nodes(own_master: Callable[[str], Master], tmp_path: Path) -> None:
    clock = Clock(tmp_path)
    master = own_master("ours")
    usual = master.environ
    there = {"PYTHONPATH": f"{tmp_path}:{SOURCE}"}
    master.environ = lambda python="stock", **extra: usual(python, **{**extra, **(there if python != "stock" else {})})  # type: ignore[method-assign]
    master.start()
    source = master.ready_peer("roscpp", "source")
    source.advertise("/t", "std_msgs/Float64", queue_size=1000)
    sink = master.ready_peer("pyros1", "sink")
    sink.subscribe("/t", "std_msgs/Float64")
    bag = tmp_path / "jumps"
    command = [sys.executable, "-m", "pyros1", "bag", "record", "-O", str(bag), "/t"]
    recorder = master.run(command, python="ours", label="recorder")
    source.linked("/t", 2)
    for seed, offset in enumerate((0.0, -HOUR, HOUR, 0.0)):
        clock.set(offset)
        assert source.publish("/t", seed) == sink.received("/t", 20)
        late = master.ready_peer("pyros1", f"late{seed}")
        late.subscribe("/t", "std_msgs/Float64")
        source.linked("/t", 3)
        assert late.quit() == 0
        source.linked("/t", 2)
    recorder.signal(signal.SIGINT)
    assert recorder.wait(60) == 0, recorder.transcript()
    until(Path(f"{bag}.bag").exists, "the bag")
    with BagReader(Path(f"{bag}.bag")) as read:
        times = [message.time for message in read.messages()]
    assert len(times) == 4 and times == sorted(times)
    assert times[1] - times[0] > 0.9 * HOUR * 1e9 and times[-1] - times[-2] > 0.9 * HOUR * 1e9
