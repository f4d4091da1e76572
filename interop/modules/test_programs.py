"""Programs that Debian's packages install, unmodified, on stock's modules and on ours: the results are the same."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest
from faces import FACES, START, run, start
from harness import SOURCE, STOCK_PYTHON, Master, Process

MASTERS = ("ours",)  # they do not ask it
pytestmark = pytest.mark.ours_only

DIST = Path("/usr/lib/python3/dist-packages")
DIAGNOSTICS = "/usr/lib/diagnostic_common_diagnostics"
SENSORS = r"coretemp-isa-0000\nAdapter: ISA adapter\nCore 0: +45.0 C (high = +80.0 C, crit = +100.0 C)\n"
PROGRAM = """
import runpy, sys
path, *sys.argv[1:] = sys.argv[1:]
sys.argv[0] = path
sys.path.insert(0, path.rpartition("/")[0])
runpy.run_path(path, run_name="__main__")
"""


@pytest.fixture(scope="module")
def others(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with Debian's modules that are not ours to provide, and one with stand-ins for programs they start."""
    folder = tmp_path_factory.mktemp("others")
    names = ("joint_state_publisher", "diagnostic_common_diagnostics", "diagnostic_analysis", "rosdiagnostic")
    for name in (*names, "dateutil", "six.py", "psutil"):
        (folder / name).symlink_to(DIST / name)
    programs = folder / "bin"
    programs.mkdir()
    for name, text in (
        ("ntpdate", 'echo "server 127.0.0.1, stratum 2, offset 0.000123, delay 0.02"'),
        ("sensors", f"printf '{SENSORS}'"),
    ):
        (programs / name).write_text(f"#!/bin/sh\n{text}\n")
        (programs / name).chmod(0o755)
    return folder


def surroundings(face: str, others: Path, **extra: str) -> dict[str, str]:
    path = {} if face == "stock" else {"PYTHONPATH": f"{START}:{SOURCE}:{others}"}
    return {**path, "PATH": f"{others / 'bin'}:{os.environ['PATH']}", "HOME": "/tmp", **extra}


def begin(face: str, master: Master, others: Path, path: str, *arguments: str) -> Process:
    """Start one of Debian's programs."""
    return start(face, master, PROGRAM, path, *arguments, **surroundings(face, others))


def finish(face: str, master: Master, others: Path, path: str, *arguments: str, code: int = 0) -> str:
    """Run one of Debian's programs to its end; return what it printed to both streams."""
    process = begin(face, master, others, path, *arguments)
    assert process.wait(60) == code, process.transcript()
    return "".join(f"{line}\n" for line in process.lines if not line.startswith("the rosdep view"))


ROBOT = """
<robot name="arm">
  <link name="base"/><link name="a"/><link name="b"/><link name="c"/><link name="d"/>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="a"/><limit lower="-1" upper="2"/></joint>
  <joint name="wheel" type="continuous"><parent link="a"/><child link="b"/></joint>
  <joint name="slide" type="prismatic"><parent link="b"/><child link="c"/><limit lower="0.5" upper="1.5"/></joint>
  <joint name="finger" type="revolute"><parent link="c"/><child link="d"/><limit lower="-1" upper="1"/>
    <mimic joint="shoulder" multiplier="0.5" offset="0.1"/></joint>
  <joint name="glue" type="fixed"><parent link="c"/><child link="d"/></joint>
</robot>
"""
PROBE = """
import sys
import rospy
from sensor_msgs.msg import JointState
rospy.init_node("probe", anonymous=True)
def show(state):
    print(state.name, [round(each, 6) for each in state.position], list(state.velocity), list(state.effort))
show(rospy.wait_for_message("joint_states", JointState, 20))
source = rospy.Publisher("source", JointState, queue_size=1, latch=True)
source.publish(JointState(name=["wheel", "slide"], position=[1.5, 0.75], velocity=[2.0, 3.0]))
while True:
    state = rospy.wait_for_message("joint_states", JointState, 20)
    if 1.5 in state.position:
        break
show(state)
"""


def test_joint_state_publisher(launcher: Master, others: Path) -> None:
    printed = []
    for face in FACES:
        set_up = f"import rospy; rospy.set_param('robot_description', {ROBOT!r}); "
        set_up += "rospy.set_param('joint_state_publisher', {'source_list': ['source'], 'rate': 50, "
        set_up += "'zeros': {'shoulder': 0.25}, 'publish_default_velocities': True})"
        run("stock", launcher, set_up)
        process = begin(face, launcher, others, "/usr/lib/joint_state_publisher/joint_state_publisher")
        printed.append(run("stock", launcher, PROBE))
        process.close()
    assert printed[0] == printed[1]
    assert "'shoulder'" in printed[0] and "1.5" in printed[0]


DIAGNOSTICS_PROBE = """
import re, sys
import rospy
from diagnostic_msgs.msg import DiagnosticArray
rospy.init_node("probe", anonymous=True)
wanted = sys.argv[1]
while True:
    array = rospy.wait_for_message("/diagnostics", DiagnosticArray, 30)
    found = [each for each in array.status if wanted in each.name and "starting" not in each.message]
    if found:
        break
for status in sorted(found, key=lambda each: each.name):
    print(status.level, status.name, re.sub("[0-9.]+ percent", "N percent", status.message), status.hardware_id)
    for value in status.values:  # those of other words change while the test runs
        print("  ", value.key, "" if {*value.key.split()} & {*sys.argv[2:]} else value.value)
"""
CHANGING = ("Update", "Available", "CPU", "RAM", "Disk")
SAME_PYTHON = pytest.mark.skipif(
    f"python{sys.version_info[0]}.{sys.version_info[1]}" != os.path.basename(os.path.realpath(STOCK_PYTHON)),
    reason="psutil is compiled for stock's Python",
)


@pytest.mark.parametrize(
    ("program", "arguments", "wanted"),
    [
        ("ntp_monitor", ("localhost", "--diag-hostname", "c1", "--no-self-test"), "NTP"),
        ("sensors_monitor", ("--diag-hostname=c1",), "Sensor"),
        ("hd_monitor", ("--diag-hostname=c1",), "HD"),
        # It warns of a busy machine, which this may be now and then.
        pytest.param("cpu_monitor", ("_warning_percentage:=101",), "CPU", marks=SAME_PYTHON),
        pytest.param("ram_monitor", (), "RAM", marks=SAME_PYTHON),
    ],
)
def test_diagnostics(launcher: Master, others: Path, program: str, arguments: tuple[str, ...], wanted: str) -> None:
    printed = []
    for face in FACES:
        process = begin(face, launcher, others, f"{DIAGNOSTICS}/{program}.py", *arguments)
        printed.append(run("stock", launcher, DIAGNOSTICS_PROBE, wanted, *CHANGING))
        process.close()
    assert printed[0] == printed[1]
    assert wanted in printed[0]


TREES = """
import rospy
from geometry_msgs.msg import TransformStamped
from tf.msg import tfMessage
rospy.init_node("trees")
publisher = rospy.Publisher("/tf", tfMessage, queue_size=10)
rate = rospy.Rate(50)
while not rospy.is_shutdown():
    transforms = []
    for parent in ("/one", "/other"):
        transform = TransformStamped(child_frame_id="/child")
        transform.header.stamp = rospy.Time.now()
        transform.header.frame_id = parent
        transform.transform.rotation.w = 1
        transforms.append(transform)
    publisher.publish(transforms)
    try:
        rate.sleep()
    except rospy.ROSInterruptException:
        break
"""


def test_tf_monitor(launcher: Master, others: Path) -> None:
    trees = start("ours", launcher, TREES)
    printed = []
    for face in FACES:
        process = begin(face, launcher, others, f"{DIAGNOSTICS}/tf_monitor.py")
        printed.append(run("stock", launcher, DIAGNOSTICS_PROBE, "Reparenting"))
        process.close()
    trees.close()
    assert printed[0] == printed[1]
    assert "child" in printed[0]


BAG = """
import sys
import rosbag, rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
with rosbag.Bag(sys.argv[1], "w") as bag:
    for number in range(25):
        array = DiagnosticArray()
        array.header.stamp = rospy.Time(1000 + number)
        for name in ("Motor/left", "Battery, big"):
            values = [KeyValue("Volt, age", str(number / 4)), KeyValue("State", "on" if number % 2 else "off")]
            array.status.append(DiagnosticStatus(number % 3, name, "message; %d" % number, "id", values))
        bag.write("/diagnostics", array, rospy.Time(1000 + number))
"""


def test_diagnostic_analysis(launcher: Master, others: Path, tmp_path: Path) -> None:
    """Tables of diagnostics from a bag, and thinned ones."""
    bag = tmp_path / "log.bag"
    run("stock", launcher, BAG, str(bag))
    made = []
    for face in FACES:
        folder = tmp_path / face
        folder.mkdir()
        said = finish(face, launcher, others, "/usr/lib/diagnostic_analysis/export_csv.py", "-d", str(folder), str(bag))
        tables = sorted(folder.rglob("*.csv"))
        for options in (["-s", "5"], ["-l", "4"]):
            said += finish(
                face, launcher, others, "/usr/lib/diagnostic_analysis/sparse_csv.py", *options, str(tables[0])
            )
        made.append((said.replace(str(folder), ""), {each.name: each.read_text() for each in folder.rglob("*.csv")}))
    assert made[0] == made[1]
    assert len(made[0][1]) == 4


DYNPARAM_SERVER = """
import rospy
from dynamic_reconfigure.server import Server
from pyros1.reconfigure import Parameters
parameters = Parameters()
parameters.add("int_", 1, "a number", maximum=10, choices={"Small": 1, "Large": 9})
group = parameters.group("Group")
group.add("str_", "a", "a text")
parameters.group("Inner", parent=group).add("bool_", True, "a truth")
rospy.init_node("configured")
server = Server(parameters, lambda config, level: config)
print("ready", flush=True)
rospy.spin()
"""


def test_dynparam(launcher: Master, others: Path, tmp_path: Path) -> None:
    """Stock's dynparam on our modules; its files are read by both."""
    start("ours", launcher, DYNPARAM_SERVER).wait_line("^ready$")
    printed, files = [], []
    for face in FACES:
        file = tmp_path / f"{face}.yaml"
        said = ""
        for words in (
            ["list"],
            ["set", "configured", "int_", "3"],
            ["set", "configured", "int_", "large"],
            ["set", "configured", "{'int_': 4, 'str_': 'x', 'bool_': false}"],
            ["set", "configured", "other", "1"],
            ["get", "configured"],
            ["dump", "configured", str(file)],
            ["set", "configured", "int_", "5"],
            ["load", "configured", str(tmp_path / "stock.yaml")],
            ["get", "configured"],
            ["set_from_parameters", "configured", "_int_:=77"],
            ["get", "configured", "-t", "5"],
        ):
            said += finish(face, launcher, others, "/usr/lib/dynamic_reconfigure/dynparam", *words)
        printed.append(said)
        files.append(file.read_text())
    assert printed[0] == printed[1]
    assert files[0] == files[1]
    assert "'int_': 10" in printed[0]


MUX_READY = """
import rospy
rospy.wait_for_service("mux/list", 20)
"""


def test_mux_tools(launcher: Master, others: Path) -> None:
    """The scripts that control a mux in C++."""
    mux = Process(["/usr/lib/topic_tools/mux", "chosen", "one", "two"], launcher.environ("stock"), label="mux")
    launcher.processes.append(mux)
    run("stock", launcher, MUX_READY)
    printed = []
    for face in FACES:
        said = ""
        for name, *words in (
            ("list", "mux"),
            ("add", "mux", "three"),
            ("select", "mux", "three"),
            ("select", "mux", "one"),
            ("delete", "mux", "three"),
            ("list", "mux"),
        ):
            said += finish(face, launcher, others, f"/usr/lib/topic_tools/mux_{name}", *words)
        printed.append(said)
    assert printed[0] == printed[1]


ARRAYS = """
import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
rospy.init_node("arrays")
publisher = rospy.Publisher("/diagnostics_agg", DiagnosticArray, queue_size=1, latch=True)
array = DiagnosticArray()
array.header.stamp = rospy.Time(1000)
for level, name in enumerate(("/Fine", "/Warm", "/Bad", "/Stale")):
    array.status.append(DiagnosticStatus(level, name, "message", "id", [KeyValue("key", "value")]))
publisher.publish(array)
rospy.spin()
"""
ROSDIAGNOSTIC = "from rosdiagnostic import rosdiagnosticmain; rosdiagnosticmain()"


def test_rosdiagnostic(launcher: Master, others: Path, tmp_path: Path) -> None:
    start("ours", launcher, ARRAYS)
    script = tmp_path / "rosdiagnostic"
    script.write_text(ROSDIAGNOSTIC)
    for options in (["--nocolor"], ["-d", "-l", "0"], ["--filter", "/B.*", "-d", "--nocolor"]):
        printed = [finish(face, launcher, others, str(script), *options) for face in FACES]
        assert printed[0] == printed[1]
        assert "/Bad" in printed[0]
