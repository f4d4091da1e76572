"""Diagnostics of nodes; stock: interop/modules/test_diagnostic_updater.py."""

from __future__ import annotations

import queue
from typing import Any

from pyros1.diagnostics import ERROR, OK, WARN, Combined, Frequency, Status, TimeStamps, Updater, alive
from pyros1.ground.timing import Duration, Time
from pyros1.msgs.diagnostic_msgs.msg import DiagnosticArray


class Clock:
    """A clock that stands still until it is moved."""

    def __init__(self) -> None:
        self.time = Time(100)

    def now(self) -> Time:
        return self.time

    def move(self, seconds: float) -> None:
        self.time += Duration(seconds)


def result(task: Any) -> tuple[int, str, dict[str, str]]:
    status = Status()
    task(status)
    return status.level, status.message, {each.key: each.value for each in status.values}


def test_summaries() -> None:
    status = Status()
    for level, message, expected in (
        (OK, "a", (OK, "a")),
        (OK, "b", (OK, "a; b")),
        (WARN, "c", (WARN, "c")),
        (OK, "d", (WARN, "c")),
        (ERROR, "e", (ERROR, "c; e")),
    ):
        status.merge(level, message)
        assert (status.level, status.message) == expected


def test_frequency() -> None:
    clock = Clock()
    task = Frequency(clock.now, 9, 11, window=2)
    assert result(task.run)[:2] == (ERROR, "No events recorded.")
    task.tick()
    assert result(task.run)[:2] == (OK, "Desired frequency met")  # no time has passed
    for count, expected in ((10, "Desired frequency met"), (5, "Frequency too low."), (40, "Frequency too high.")):
        task.clear()
        for _ in range(count):
            task.tick()
        clock.move(1)
        level, message, values = result(task.run)
        assert (level, message) == (OK if count == 10 else WARN, expected)
        assert values["Actual frequency (Hz)"] == f"{count:f}"
    task.maximum = None
    level, message, values = result(task.run)
    assert message == "Desired frequency met" and "Maximum acceptable frequency (Hz)" not in values


def test_time_stamps() -> None:
    clock = Clock()
    task = TimeStamps(clock.now)
    assert result(task.run)[:2] == (WARN, "No data since last update.")
    for stamp, expected in ((99.0, "Timestamps are reasonable."), (90.0, "Timestamps too far in past seen.")):
        task.tick(stamp)
        assert result(task.run)[1] == expected
    task.tick(Time(110))
    level, message, values = result(task.run)
    assert (level, message) == (ERROR, "Timestamps too far in future seen.")
    assert values["Early diagnostic update count:"] == "1" and values["Late diagnostic update count:"] == "1"


def test_several_tasks_in_one() -> None:
    level, message, values = result(Combined([alive, lambda status: status.summary(WARN, "hot")]).run)
    assert (level, message, values) == (WARN, "hot", {})


def test_updater(make_node: Any) -> None:
    arrays: queue.Queue[Any] = queue.Queue()
    make_node("monitor").subscribe("/diagnostics", DiagnosticArray, arrays.put)

    def fails(status: Status) -> None:
        raise ValueError("no hardware")

    def battery(status: Status) -> None:
        status.summary(OK, "charged")
        status.add("Voltage", 12.5)

    node = make_node("driver", namespace="/robot")
    updater = Updater(node, "serial 5", period=0)
    assert node.advertise("/diagnostics", DiagnosticArray).wait_for_subscribers(1, 10.0)
    updater.add("Battery", battery)
    updater.add("Motor", fails)
    updater.add("Nothing", lambda status: None)
    assert updater.remove("Nothing") and not updater.remove("Nothing")
    updater.update()
    updater.broadcast(WARN, "ends")
    found = [[(s.level, s.name, s.message, s.hardware_id) for s in arrays.get(timeout=20).status] for _ in range(5)]
    assert found[0] == [(OK, "robot/driver: Battery", "Node starting up", "")]
    assert found[3] == [
        (OK, "robot/driver: Battery", "charged", "serial 5"),
        (ERROR, "robot/driver: Motor", "ValueError: no hardware", "serial 5"),
    ]
    assert found[4] == [(WARN, f"robot/driver: {name}", "ends", "") for name in ("Battery", "Motor")]
    updater.close()


def test_the_updater_runs_by_itself(make_node: Any) -> None:
    arrays: queue.Queue[Any] = queue.Queue()
    make_node("monitor").subscribe("/diagnostics", DiagnosticArray, arrays.put)
    node = make_node("driver")
    node.params["~diagnostic_period"] = 0.01
    updater = Updater(node)
    updater.add("Alive", alive)
    messages = [arrays.get(timeout=20).status[0].message for _ in range(3)]
    assert messages[-1] == "Alive"
    updater.close()
