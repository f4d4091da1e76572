"""diagnostic_updater: tasks, summaries and the updater on stock's modules and on ours."""

from __future__ import annotations

import pytest
from faces import run, same, start
from harness import Master

MASTERS = ("ours",)  # they do not ask it
pytestmark = pytest.mark.ours_only

TASKS = """
import random
import rospy
from diagnostic_updater import *
clock = [100.0]
rospy.Time.now = staticmethod(lambda: rospy.Time.from_sec(clock[0]))

def show(task):
    status = DiagnosticStatusWrapper()
    status.summary(ERROR, "No message was set")
    assert task.run(status) is status
    print(status.level, repr(status.message), [(each.key, each.value) for each in status.values])

rng = random.Random(5)
for case in range(40):
    low = rng.choice((0, 0.5, 2.0, 10))
    bounds = {"min": low, "max": rng.choice((low, low + 5, float("inf")))}
    vector = DiagnosticTaskVector()
    params = FrequencyStatusParam(bounds, rng.choice((0, 0.1, 0.5)), rng.choice((1, 2, 5)))
    if rng.random() < 0.3:
        topic = HeaderlessTopicDiagnostic("topic", vector, params)
    else:
        limits = TimeStampStatusParam(-rng.random(), rng.random()) if rng.random() < 0.5 else TimeStampStatusParam()
        topic = TopicDiagnostic("topic", vector, params, limits)
    if rng.random() < 0.5:
        topic.addTask(Heartbeat())
    print(topic.getName(), [each.name for each in vector.tasks])
    for run in range(12):
        for tick in range(rng.choice((0, 0, 1, 3, 20))):
            clock[0] += rng.choice((0.0, 0.125))
            if isinstance(topic, TopicDiagnostic):
                stamp = rng.choice((0.0, clock[0], clock[0] - rng.randrange(8), clock[0] + rng.randrange(3)))
                topic.tick(rng.choice((float, rospy.Time.from_sec))(stamp))
            else:
                topic.tick()
        if rng.random() < 0.1:
            topic.clear_window()
        bounds["max"] = bounds["max"] + rng.choice((0, 0, 0, 1))
        clock[0] += 0.5
        show(topic)
rate = FrequencyStatus(FrequencyStatusParam({"min": 1, "max": 1}), name="Rate")
clock[0] += 1
rate.tick()
show(rate)
rate.clear()
clock[0] += 1
show(rate)
stamps = TimeStampStatus(TimeStampStatusParam(0, 1), "Stamps")
stamps.tick(clock[0] - 0.5)
show(stamps)
show(DiagnosticTask("nothing"))
print(rate.getName(), stamps.getName(), TimeStampStatus().getName(), OK, DiagnosticStatusWrapper.STALE)
class Vector(DiagnosticTaskVector):
    def addedTaskCallback(self, task):
        print("added", task.name, type(task) is DiagnosticTaskVector.DiagnosticTaskInternal)
vector = Vector()
vector.add(Heartbeat())
vector.add("Function", lambda status: status)
status = DiagnosticStatusWrapper()
print(vector.tasks[1].run(status) is status, status.name, [each.name for each in vector.tasks])
for case in range(300):
    status = DiagnosticStatusWrapper()
    for step in range(4):
        level, text = rng.randrange(4), rng.choice(("", "a", "b", 5 if False else "c"))
        other = DiagnosticStatusWrapper(level=level, message=text)
        rng.choice((status.summary, status.mergeSummary, status.mergeSummary))(*rng.choice(((level, text), (other,))))
        if rng.random() < 0.1:
            status.clearSummary()
    status.add("key", rng.choice((1, 2.5, None, True, "text", b"b", [1])))
    print(status.level, repr(status.message), [(each.key, each.value) for each in status.values])
"""


def test_tasks_and_summaries(master: Master) -> None:
    assert same(master, TASKS).count("\n") > 700


SIGNATURES = """
import inspect, diagnostic_updater
for name, cls in sorted(vars(diagnostic_updater).items()):
    if inspect.isclass(cls) and cls.__module__.startswith("diagnostic_updater"):
        for member, value in sorted(inspect.getmembers(cls, inspect.isfunction)):
            home = value.__module__.startswith("diagnostic_updater") and member[0] != "_" or member == "__init__"
            if home and not name.endswith("Wrapper"):
                values = inspect.signature(value).parameters.values()
                print(name, member, [(each.name, str(each.default)[:10]) for each in values])
"""


def test_signatures(master: Master) -> None:
    assert "DiagnosedPublisher" in same(master, SIGNATURES)


UPDATER = """
import rospy
from diagnostic_msgs.msg import DiagnosticArray
from diagnostic_updater import *
from std_msgs.msg import String
rospy.init_node("updater")
rospy.set_param("~diagnostic_period", 0.25)
updater = Updater()
plenty = rospy.Publisher("/diagnostics", DiagnosticArray, queue_size=100)  # else stock drops what it cannot send at once
words = rospy.Publisher("words", String, queue_size=1)
while not updater.publisher.get_num_connections() or not words.get_num_connections():
    rospy.sleep(0.01)
def battery(status):
    status.summary(WARN, "low")
    status.add("Voltage", 11.5)
    return status
def useless(status):
    return None
updater.add("Battery", battery)
updater.add("Useless", useless)
updater.add(Heartbeat())
composite = CompositeDiagnosticTask("Both")
composite.addTask(FunctionDiagnosticTask("one", battery))
composite.addTask(Heartbeat())
updater.add(composite)
updater.force_update()
updater.setHardwareID("serial")
print(updater.removeByName("Heartbeat"), updater.removeByName("Nothing"), len(updater.tasks))
before = updater.last_time
while updater.last_time == before:
    updater.update()
    rospy.sleep(0.01)
print((updater.last_time - before).to_sec() >= 0.25, updater.period)
updater.broadcast(2, "ends")
updater.publish(DiagnosticStatus(name="raw"))
print("done", flush=True)
words.publish("end")
rospy.spin()
"""
LISTENER = """
import rospy
from diagnostic_msgs.msg import DiagnosticArray
from std_msgs.msg import String
rospy.init_node("listener")
count = [0]
def take(array):
    assert abs((rospy.Time.now() - array.header.stamp).to_sec()) < 30
    for each in array.status:
        values = [(value.key, value.value) for value in each.values]
        print(each.level, each.name, each.message, each.hardware_id, values)
    count[0] += 1
    if count[0] == 8:
        rospy.signal_shutdown("")
rospy.Subscriber("/diagnostics", DiagnosticArray, take)
rospy.Subscriber("words", String, lambda word: None)
rospy.spin()
"""


def test_updaters(master: Master, launcher: Master) -> None:
    """The same messages from an updater on stock, heard by ours, and the other way round.

    Feature: diagnostics: updater and tasks; equal to diagnostic_updater -- `pyros1.diagnostics`
    """
    said, heard = [], []
    for face, other in (("stock", "ours"), ("ours", "stock")):
        updater = start(face, launcher, UPDATER)
        heard.append(run(other, launcher, LISTENER))
        updater.wait_line("done")
        said.append([line for line in updater.lines if line[0] != "["])  # no log
        updater.close()
    assert heard[0] == heard[1]
    assert heard[0].count("updater: Battery") == 4
    assert said[0] == said[1]
