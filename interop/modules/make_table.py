"""Write ``interop/modules.md``: which names of stock's Python modules public programs use, and which of them ours have.

::

    python interop/modules/make_table.py
    python interop/modules/make_table.py --check    # exit code 1 if the page is not current

A name counts as tested if it occurs in the syntax tree of a test program in ``interop/modules`` or ``tests/drop_in``
that imports the module, see `uses`.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from pathlib import Path

from speed_verdict import with_ratios
from uses import used_names

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
PAGE = ROOT / "interop" / "modules.md"
SPEED = HERE / "speed.md"
"""Figures of `python interop/bench/run.py --only rospy:`, put there by hand."""
USED = ROOT / "tests" / "drop_in" / "used_names.txt"
"""Names of stock's modules that public programs use."""
START = ROOT / "src" / "pyros1" / "drop_in" / "start"

MODULES = """
rospy rospy.client rospy.core rospy.exceptions rospy.msg rospy.msproxy rospy.names rospy.numpy_msg rospy.rostime
rospy.service rospy.timer rospy.topics rospy.logger_level_service_caller rospy.impl.tcpros_base
rospy.impl.tcpros_service rospy.impl.paramserver rospy.impl.transport rospy.impl.registration
genpy genpy.message genpy.rostime genpy.dynamic genpy.base genpy.generator
genmsg genmsg.base genmsg.names genmsg.msgs genmsg.msg_loader genmsg.gentools
roslib roslib.message roslib.packages roslib.names roslib.msgs roslib.srvs roslib.manifest roslib.rospack roslib.rosenv
roslib.scriptutil roslib.network roslib.launcher
rosgraph rosgraph.masterapi rosgraph.names rosgraph.network rosgraph.rosenv rosgraph.xmlrpc rosgraph.impl.graph
rosgraph.roslogging rospkg rospkg.environment rospkg.common
rosbag rosbag.bag rosbag.migration rosbag.rosbag_main rostopic rosnode rosservice rosparam rosmsg
roslaunch roslaunch.parent roslaunch.scriptapi roslaunch.rlutil roslaunch.xmlloader roslaunch.core roslaunch.config
roslaunch.pmon roslaunch.loader roslaunch.launch roslaunch.substitution_args rostest rosunit rosunit.junitxml
tf tf.transformations tf.broadcaster tf.listener tf2_ros tf2_py tf2_geometry_msgs tf2_sensor_msgs
actionlib actionlib.action_client actionlib.action_server actionlib.simple_action_client
actionlib.simple_action_server actionlib.server_goal_handle actionlib.goal_id_generator
actionlib.handle_tracker_deleter actionlib.status_tracker actionlib.exceptions
dynamic_reconfigure dynamic_reconfigure.server dynamic_reconfigure.client dynamic_reconfigure.encoding
dynamic_reconfigure.parameter_generator dynamic_reconfigure.parameter_generator_catkin
message_filters diagnostic_updater topic_tools sensor_msgs.point_cloud2 cv_bridge laser_geometry
interactive_markers.interactive_marker_server interactive_markers.menu_handler
""".split()  # noqa: SIM905  shorter as text

BEGINNING = """# Python modules of stock ROS 1, and ours

Written by `interop/modules/make_table.py`; not to be changed by hand. It counts what programs use: {used} names of stock's
modules, found in 44 public packages and by searching public code (`tests/drop_in/used_names.txt`). *There* means that our
module has the name, which `tests/drop_in/test_used_names.py` shows; *tested* that it occurs in the code of a test program in
`interop/modules` or `tests/drop_in` that imports the module (in its syntax tree or that of a program in a string; comments and
other strings do not count). What tests use by the name of another module, as rospy.Timer for rospy.timer.Timer, counts there only.

Other names of stock are there if they cost little. What is not there raises an error that says what to use in its place.

| module | names that programs use | there | tested | missing |
|---|---|---|---|---|
"""
PROGRAMS = """
## Programs

Programs that Debian's packages install, unmodified, with the same results on stock's modules and on ours:

| programs | tests in `interop/modules` |
|---|---|
| rostopic, rosnode, rosservice, rosparam, rosmsg, rosgraph, roswtf with our modules below them | `test_stock_tools.py` |
| roslaunch-deps, -logs, -complete and -check, more scripts of rosbag and tf, rostest's nodes | `test_stock_scripts.py` |
| rosbag and its scripts, roslaunch, rostest, topic_tools' relay_field, transform and mux_select, dynparam | `test_stock_programs.py` |
| joint_state_publisher, diagnostic_common_diagnostics, diagnostic_analysis, rosdiagnostic, tf_monitor of Python | `test_programs.py` |
| tf's and tf2_tools' programs, buffer servers and clients | `test_tf_programs.py` |
| actionlib_tools' library; clients and servers of actionlib in all pairs, with roscpp too | `test_actionlib.py` |
| axclient and axserver of actionlib_tools, with a stand-in for wxPython | `test_action_windows.py` |
| image_view's extract_images_sync | `test_image_view.py` |
| camera_calibration: calibrator, its node without a window, camera checker | `test_camera_calibration.py` |
| rosunit, interactive_markers, laser_geometry, image_geometry, message_filters | `test_rosunit.py` and so on |
| ports of the classic tutorials, in mixed pairs too | `test_tutorials.py` |

No test opens a window: axclient and axserver print what theirs would show, and camera_calibration's are left out. Compiled
modules, such as PyKDL, are left out; what Python offers of them is in `tf2_kdl` and `tf_conversions`.
"""


def present(names: dict[str, list[str]]) -> dict[str, list[str]]:
    """Return which names of modules ours have."""
    environ = {"PATH": os.environ["PATH"], "HOME": "/nonexistent", "PYTHONPATH": f"{START}{os.pathsep}{ROOT / 'src'}"}
    command = [sys.executable, str(HERE / "surface.py"), "have"]
    done = subprocess.run(
        command, input=json.dumps(names), env=environ, capture_output=True, text=True, timeout=300, check=True
    )
    answer: dict[str, list[str]] = json.loads(done.stdout.splitlines()[-1])
    return answer


def by_module(names: list[str]) -> dict[str, list[str]]:
    """Return names of modules by the module of `MODULES` that has each, without the modules themselves."""
    found: dict[str, list[str]] = {module: [] for module in MODULES}
    for name in names:
        module = max((each for each in MODULES if name.startswith(f"{each}.")), key=len, default="")
        if module and name not in found:
            found[module].append(name[len(module) + 1 :])
    return {module: each for module, each in found.items() if each}


def test_programs() -> list[Path]:
    """Return the test programs, without those that have lists of names."""
    found = [path for folder in (HERE, ROOT / "tests" / "drop_in") for path in sorted(folder.rglob("*.py"))]
    return [path for path in found if path not in (Path(__file__), HERE / "surface.py", HERE / "signatures.py")]


def page() -> str:
    """Return the text of the page."""
    wanted = by_module(USED.read_text(encoding="utf-8").split())
    ours = present(wanted)
    used = used_names(test_programs(), MODULES)
    rows: list[str] = []
    sums = [0, 0, 0]
    for module, names in wanted.items():
        there = ours[module] or []
        tested = [name for name in there if name.rpartition(".")[2] in used[module]]
        missing = ", ".join(f"`{name}`" for name in names if name not in there)
        rows.append(f"| `{module}` | {len(names)} | {len(there)} | {len(tested)} | {missing} |\n")
        for index, part in enumerate((names, there, tested)):
            sums[index] += len(part)
    rows.append(f"| all | {sums[0]} | {sums[1]} | {sums[2]} | |\n")
    return BEGINNING.format(used=sums[0]) + "".join(rows) + PROGRAMS + with_ratios(SPEED.read_text(encoding="utf-8"))


def main() -> int:
    """Write or check the page; return the exit code."""
    parser = argparse.ArgumentParser(description="Write interop/modules.md.")
    parser.add_argument("--check", action="store_true", help="write nothing; exit code 1 if the page is not current")
    options = parser.parse_args()
    text = page()
    if options.check:
        return int(not PAGE.exists() or PAGE.read_text(encoding="utf-8") != text)
    PAGE.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
