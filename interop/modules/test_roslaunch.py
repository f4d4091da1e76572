"""roslaunch as a library on stock's modules and on ours."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from faces import FACES, run
from harness import Master

MASTERS = ("ours", "stock")
PACKAGE = "<package format='2'><name>scripted</name><version>1.0.0</version></package>"
NODE = """#!/bin/sh
# "stay" runs on; other words are exit codes
trap 'exit 0' INT TERM
[ "$1" = stay ] || { sleep 3; exit "$1"; }  # stock takes a quick end for a failed start
while :; do sleep 0.05; done
"""
LAUNCH = """<launch>
  <arg name="x" default="5" doc="the x"/>
  <arg name="y" default="stay"/>
  <param name="p" value="$(arg x)"/>
  <param name="s" value="text" type="str"/>
  <rosparam>{q: [1, 2.5], d: {e: true}}</rosparam>
  <env name="E1" value="v1"/>
  <machine name="m" address="localhost" default="never"/>
  <group ns="g" clear_params="true">
    <remap from="a" to="b"/>
    <node pkg="scripted" type="run" name="one" args="$(arg y) 'two three'" output="screen" cwd="node">
      <param name="priv" value="1.5"/>
      <env name="E2" value="v2"/>
      <remap from="c" to="/d"/>
    </node>
  </group>
  <node pkg="scripted" type="run" name="two" machine="m" args="stay"/>
  <test test-name="t" pkg="rospy" type="t.py" time-limit="12" retry="2" name="tt"/>
</launch>
"""


@pytest.fixture
def package(launcher: Master, tmp_path: Path) -> dict[str, str]:
    """A package with a node and a launch file; returns the environment variable for it."""
    folder = tmp_path / "scripted"
    folder.mkdir()
    (folder / "package.xml").write_text(PACKAGE)
    (folder / "run").write_text(NODE)
    (folder / "run").chmod(0o755)
    (folder / "a.launch").write_text(LAUNCH)
    (folder / "bad.launch").write_text('<launch><node pkg="x"/></launch>')
    return {"ROS_PACKAGE_PATH": str(tmp_path)}


def told(face: str, master: Master, text: str, package: dict[str, str]) -> list[str]:
    """Return the lines of a program's output that begin with "=", without what differs on purpose."""
    lines = run(face, master, text, **package).splitlines()
    return [re.sub(r"0x\w+", "", line) for line in lines if line.startswith("= ")]


def same_lines(master: Master, text: str, package: dict[str, str]) -> list[str]:
    stock, ours = (told(face, master, text, package) for face in FACES)
    assert ours == stock
    return ours


READING = """
import os
import roslaunch, roslaunch.config, roslaunch.xmlloader, roslaunch.arg_dump, roslaunch.node_args
from roslaunch.core import Machine, Master, Node, Param, Test, RLException
def show(*words):
    print("=", *[str(word).replace("\\n", "|") for word in words])
files = roslaunch.rlutil.resolve_launch_arguments(["scripted", "a.launch", "x:=7"])
show([os.path.basename(file) for file in files])
config = roslaunch.config.load_config_default(files, 11311)
for node in config.nodes + config.tests:
    show(node.package, node.type, node.name, node.namespace, node.machine_name, repr(node.args), node.respawn,
         node.respawn_delay, node.remap_args, node.env_args, node.process_name, node.output, node.cwd,
         node.launch_prefix, node.required, os.path.basename(node.filename), node.machine.name)
show(config.tests[0].test_name, config.tests[0].time_limit, config.tests[0].retry)
show(config.clear_params, config.executables, sorted(config.machines), config.config_errors, config.has_remote_nodes())
show([str(param) for name, param in sorted(config.params.items()) if name[:5] != "/rosd" and name[:5] != "/rosv"])
show([machine.address + str(machine.assignable) for machine in config.machines.values()], config.machines[""])
show(sorted(name for name in config.resolved_node_names if name != "/rosout"))
show(config.master.type, config.master.get_port())
show(roslaunch.arg_dump.get_args(files))
show(roslaunch.node_args.get_node_list(config))
other = roslaunch.config.ROSLaunchConfig()
loader = roslaunch.xmlloader.XmlLoader()
loader.load(files[0], other, argv=["x:=8"], verbose=False)
show(other.params["/p"].value, [node.name for node in other.nodes])
loader.load_string('<launch><param name="z" value="1"/></launch>', other, verbose=False)
show(other.params["/z"])
def fails(function, *arguments, **options):
    try:
        function(*arguments, **options)
        show("fine")
    except (RLException, ValueError) as error:
        show(RLException in type(error).__mro__, isinstance(error, ValueError))
fails(roslaunch.config.load_config_default, ["/nowhere.launch"], 11311)
fails(roslaunch.config.load_config_default, [os.path.join(os.path.dirname(files[0]), "bad.launch")], 11311)
fails(roslaunch.rlutil.resolve_launch_arguments, ["/nowhere.launch"])
fails(Node, "", "x")
fails(Node, "x", "")
fails(Node, "x", "y", respawn=True, required=True)
fails(Node, "x", "y", output="screen", namespace="a//b")
fails(other.add_node, other.nodes[0], verbose=False)
fails(other.add_node, Node("a", "b"), verbose=False)
fails(other.add_param, Param("/p/q", 1), verbose=False)
fails(other.add_machine, Machine("m", "other"), verbose=False)
fails(Test, "t", "a", "b", time_limit=-1)
show(roslaunch.config.namespaces_of("/a/b/c"), roslaunch.config.namespaces_of("/a"))
show(Param("a//b/", 1).key, Param("/x", 1) == Param("/x", 1), Param("/x", 1) != Param("/x", 2))
show(Node("p", "t", "n", "x//y").namespace, Test("name", "p", "t").time_limit)
show([roslaunch.loader.convert_value(*words) for words in (("5", "int"), ("5.5", "auto"), ("true", "bool"), ("x", "str"))])
fails(roslaunch.loader.convert_value, "x", "int")
show(len(roslaunch.core.generate_run_id()), roslaunch.core.TEST_TIME_LIMIT_DEFAULT, roslaunch.core.local_machine())
show(Machine("a", "b", user="u") == Machine("a", "b", user="u"), Machine("a", "b").config_equals(Machine("c", "b")))
"""


def test_reading(launcher: Master, package: dict[str, str]) -> None:
    assert "= 8 ['one', 'two']" in same_lines(launcher, READING, package)


DUMPS = """
import os, roslaunch, roslaunch.arg_dump, roslaunch.node_args, roslaunch.param_dump
path = os.path.join(os.environ["ROS_PACKAGE_PATH"], "dumped.launch")
def write(text):
    with open(path, "w") as file:
        file.write("<launch>" + text + "</launch>")
write("<arg name='b' doc='the b'/><arg name='a'/><arg name='d' default='5' doc='the d'/><arg name='c' default=''/>"
      "<arg name='v' value='x' doc='vv'/>")
roslaunch.arg_dump.dump_args([path])
print(roslaunch.arg_dump.get_args([path]))
write("")
roslaunch.arg_dump.dump_args([path])
roslaunch.param_dump.dump_params([path])
write("<param name='a' value='1'/><param name='b/c' value='x'/><node pkg='p' type='t' name='n' ns='m'/>")
roslaunch.param_dump.dump_params([path])
roslaunch.node_args.print_node_list([path])
roslaunch.node_args.print_node_filename("/m/n", [path])
roslaunch.rlutil.print_file_list([path])
write("<group ns='g'><env name='E' value='v'/><node pkg='scripted' type='run' name='one' args='a &quot;b c&quot;'>"
      "<remap from='c' to='/d'/></node></group>")
print(roslaunch.node_args.get_node_args("/g/one", [path]))
roslaunch.node_args.print_node_args("g/one", [path])
try:
    roslaunch.node_args.get_node_args("/nobody", [path])
except roslaunch.RLException as error:
    print(error)
"""


def test_what_is_printed(launcher: Master, package: dict[str, str]) -> None:
    stock, ours = (run(face, launcher, DUMPS, **package).splitlines() for face in FACES)
    assert [line for line in ours if "roscore.xml" not in line] == [line for line in stock if "roscore.xml" not in line]


TEXTS = """
import os, roslaunch.substitution_args as subst
os.environ["V"] = "value"
context = {"arg": {"x": "5", "name": "scripted", "flag": "true"}}
for text in ("plain", "$(env V)", "a$(optenv NOPE)b", "$(optenv NOPE some words)", "$(arg x)$(arg name)",
             "$(eval 1 + arg('x'))", "$(eval x * 2)", "$(eval env('V') + 'x')", "$ $x $(", "",
             "$(find scripted)/$(arg name)", "$(arg nope)", "$(env NOPE)", "$(nope x)", "$(find nope_nope)", "$(arg)",
             "$(eval 'a' if flag else 'b')", "$(optenv)"):
    try:
        found = subst.resolve_args(text, context, filename="/some/where.launch")
        print("=", text, "->", found.replace(os.environ["ROS_PACKAGE_PATH"], "PATH"))
    except subst.ArgException as error:
        print("=", text, "ArgException", error)
    except subst.SubstitutionException as error:
        print("=", text, "SubstitutionException")
    except Exception as error:
        print("=", text, "other", type(error).__name__ in ("ResourceNotFound",))
one = subst.resolve_args("$(anon a)", context)
print("=", one == subst.resolve_args("$(anon a)", context), one.startswith("a_"), sorted(context["anon"]))
"""


def test_substitution(launcher: Master, package: dict[str, str]) -> None:
    lines = [told(face, launcher, TEXTS, package) for face in FACES]
    for stock, ours in zip(*lines, strict=True):
        if "nope_nope" not in stock:  # stock's exception is rospkg's
            assert ours == stock


SHOW = """
import sys
def show(*words):  # in one piece, and on a line of its own: a launch prints, too
    sys.stdout.write("\\n" + " ".join(["=", *map(str, words)]) + "\\n")
"""
PARENT = """
import os, threading, time
import roslaunch
uuid = roslaunch.rlutil.get_or_generate_uuid(None, False)
roslaunch.configure_logging(uuid)
died = threading.Semaphore(0)
heard = []
class Listener(roslaunch.pmon.ProcessListener):
    def process_died(self, name, exit_code):
        heard.append((name, exit_code))
        died.release()
file = roslaunch.rlutil.resolve_launch_arguments(["scripted", "a.launch"])[0]
parent = roslaunch.parent.ROSLaunchParent(uuid, [(file, ["y:=3", "x:=9"])], process_listeners=[Listener()])
parent.start()
assert died.acquire(timeout=20)
import xmlrpc.client
master = xmlrpc.client.ServerProxy(os.environ["ROS_MASTER_URI"])
show([(name.rpartition("-")[0], code) for name, code in heard])
show(master.getParam("/me", "/p")[2], master.getParam("/me", "/g/one/priv")[2])
end = time.monotonic() + 20  # the listeners are told before the process is forgotten
while any(name.startswith("g/one") for name in parent.pm.get_active_names()) and time.monotonic() < end:
    time.sleep(0.01)
show([node.name for node in parent.config.nodes], [parent.runner.is_node_running(n) for n in parent.config.nodes])
show([name.rpartition("-")[0] for name in parent.pm.get_active_names() if "rosout" not in name])
parent.shutdown()
show("end")
"""
SCRIPT = """
import os, roslaunch, time, xmlrpc.client
master = xmlrpc.client.ServerProxy(os.environ["ROS_MASTER_URI"])
if not master.hasParam("/me", "/run_id")[2]:  # stock waits for it
    master.setParam("/me", "/run_id", "the-run")
launch = roslaunch.scriptapi.ROSLaunch()
try:
    launch.launch(roslaunch.core.Node("scripted", "run", name="early"))
except roslaunch.RLException as error:
    show(error)
launch.start()
process = launch.launch(roslaunch.core.Node("scripted", "run", name="a", namespace="/deep", args="stay"))
show(process.is_alive(), process.name.rpartition("-")[0], process.package, process.exit_code, process.pid > 0)
info = process.get_info()
show(info["alive"], info["respawn"], info["required"])
process.stop([])
end = time.monotonic() + 20
while process.is_alive() and time.monotonic() < end:
    time.sleep(0.01)
show(process.is_alive())
other = launch.launch(roslaunch.core.Node("scripted", "run", name="b", args="3"))
while other.is_alive() and time.monotonic() < end:
    time.sleep(0.01)
show(other.exit_code)
for wrong in ("text", None):
    try:
        launch.launch(wrong)
    except ValueError as error:
        show(error)
try:
    launch.launch(roslaunch.core.Node("no_such_package", "run", name="c"))
    show("launched")
except roslaunch.RLException:
    show("RLException")
launch.stop()
"""
RUNNER = """
import os, threading
import roslaunch, roslaunch.launch
config = roslaunch.config.ROSLaunchConfig()
config.add_param(roslaunch.core.Param("/runner/p", [1, 2]), verbose=False)
config.add_node(roslaunch.core.Node("scripted", "run", name="r", args="stay"), verbose=False)
config.assign_machines()
pm = roslaunch.pmon.start_process_monitor()
died = threading.Event()
class Listener(roslaunch.pmon.ProcessListener):
    def process_died(self, name, exit_code):
        died.set()
run_id = roslaunch.rlutil.get_or_generate_uuid(None, False)
runner = roslaunch.launch.ROSLaunchRunner(run_id, config, server_uri="http://localhost:1", pmon=pm)
runner.add_process_listener(Listener())
started, failed = runner.launch()
show(started, failed)
show(runner.is_node_running(config.nodes[0]))
extra, worked = runner.launch_node(roslaunch.core.Node("scripted", "run", name="more", args="stay"))
show(worked, extra.is_alive(), extra.name.rpartition("-")[0])
show(pm.has_process(extra.name), pm.has_process("nobody"), pm.kill_process("nobody"))
import xmlrpc.client
show(xmlrpc.client.ServerProxy(os.environ["ROS_MASTER_URI"]).getParam("/me", "/runner/p")[2])
roslaunch.pmon.shutdown_process_monitor(pm)
show(pm.is_shutdown)
runner.stop()
try:
    roslaunch.launch.ROSLaunchRunner(None, config)
except roslaunch.RLException as error:
    show(error)
"""
ENDS = """
import time
import roslaunch
roslaunch.pmon._init_signal_handlers()
text = "<launch><node pkg='scripted' type='run' name='short' args='0'/></launch>"
for stays in (True, False):
    parent = roslaunch.parent.ROSLaunchParent(roslaunch.rlutil.get_or_generate_uuid(None, False), [],
                                              roslaunch_strs=[text])
    parent.start(auto_terminate=not stays)
    end = time.monotonic() + 20
    while not parent.pm.dead_list and time.monotonic() < end:
        time.sleep(0.02)
    if not stays:
        parent.pm.join(20)
    show(parent.pm.is_alive(), parent.pm.done, parent.pm.is_shutdown, len(parent.pm.dead_list))
    parent.shutdown()
    show(parent.pm.is_alive(), parent.pm.done, parent.pm.is_shutdown)
"""
SPINS = """
import os, subprocess
import roslaunch, roslaunch.launch
folder = os.path.join(os.environ["ROS_PACKAGE_PATH"], "scripted")
with open(os.path.join(folder, "short.launch"), "w") as file:
    file.write("<launch><node pkg='scripted' type='run' name='short' args='0'/></launch>")
parent = roslaunch.parent.ROSLaunchParent(roslaunch.rlutil.get_or_generate_uuid(None, False), [file.name])
for use in (parent.spin, parent.spin_once):
    try:
        use()
    except Exception as error:
        show(type(error).__name__, error)
parent.start()
show(parent.spin(), bool(parent.spin_once()), parent.pm.is_shutdown, parent.pm.get_active_names(), parent.pm.name[:14])
parent.shutdown()
parent.shutdown()
launch = roslaunch.scriptapi.ROSLaunch()
launch.start()
roslaunch.pmon.pmon_shutdown()
show(launch.spin(), bool(launch.spin_once()))
launch.stop()
config = roslaunch.config.ROSLaunchConfig()
runner = roslaunch.launch.ROSLaunchRunner(parent.run_id, config)
try:
    runner.run_test(roslaunch.core.Node("scripted", "run", name="x"))
except Exception as error:
    show(isinstance(error, Exception))
program = "import sys, roslaunch; roslaunch.main(sys.argv)"
for words in (["--find-node", "/short", "scripted", "short.launch"], ["--no-such-option"]):
    done = subprocess.run([sys.executable, "-c", program, *words], capture_output=True, text=True, timeout=30)
    show(words, done.returncode, done.stdout.split("\\n"))
"""

PROCESSES = """
import os, signal, time
import roslaunch
text = '''<launch><node pkg="scripted" type="run" name="one" args="stay" respawn="true" respawn_delay="0.1"/>
<node pkg="scripted" type="run" name="two" args="stay"/><node pkg="scripted" type="run" name="three" args="4"/></launch>'''
parent = roslaunch.parent.ROSLaunchParent(roslaunch.rlutil.get_or_generate_uuid(None, False), [], roslaunch_strs=[text])
parent.start(auto_terminate=False)
pm = parent.pm
def until(condition):
    end = time.monotonic() + 20
    while not condition():
        assert time.monotonic() < end, [(each.name, each.pid) for each in pm.procs]
        time.sleep(0.02)
def named(name):
    return next((each for each in pm.procs if each.name.startswith(name)), None)
until(lambda: pm.dead_list)
show([(each.name, each.package, each.respawn, each.respawn_delay, each.required, each.is_alive()) for each in pm.procs])
show([(each.name, each.exit_code, each.package, each.is_alive()) for each in pm.dead_list])
show(pm.get_active_names(), pm.get_process_names_with_spawn_count())
show(all(os.getpgid(each.pid) == each.pid for each in pm.procs), named("one") is named("one"))
show([word for word in named("two").args if not word.startswith("__log")][1:], type(named("two").env).__name__)
for way in ("kill_process", "stop", "signal"):
    one = named("one")
    pid = one.pid
    if way == "kill_process":
        show(pm.kill_process(one.name))
    elif way == "stop":
        one.stop([])
    else:
        os.kill(one.pid, signal.SIGKILL)
    until(lambda: named("one").is_alive() and named("one").pid != pid)
    show(way, named("one") is one)
show(pm.get_process_names_with_spawn_count()[0][0])
one.respawn = False
one.stop([])
until(lambda: len(pm.dead_list) == 2)
show(pm.get_active_names(), [each.name for each in pm.dead_list])
two = named("two")
two.respawn = True
pid = two.pid
two.stop([])
until(lambda: named("two").is_alive() and named("two").pid != pid)
show(two.get_info()["respawn"], two.get_info()["alive"], two.get_info()["spawn_count"])
parent.shutdown()
show(pm.procs, two.is_alive())
os._exit(0)
"""


@pytest.mark.parametrize(
    "text",
    [PARENT, SCRIPT, RUNNER, SPINS, ENDS, PROCESSES],
    ids=["parent", "script", "runner", "spins", "ends", "processes"],
)
def test_running(launcher: Master, package: dict[str, str], text: str) -> None:
    text = SHOW + text
    assert len(same_lines(launcher, text, package)) >= 4


WRITTEN = """
import os, time, xmlrpc.client
import roslaunch
text = '''<launch><arg name="w" default="x y"/>
<node pkg="scripted" type="run" name="one" args="3  'a  b' $(arg w)  [1,2] &quot;q&quot;" launch-prefix="nice  -n '5'"/>
</launch>'''
file = os.path.join(os.environ["ROS_PACKAGE_PATH"], "written.launch")
with open(file, "w") as out:
    out.write(text)
config = roslaunch.config.load_config_default([file], None)
show([(node.args, node.launch_prefix) for node in config.nodes], sorted(config.params))
show([value.value[-1:] for value in config.params.values()] == ["\\n", "\\n"])
uuid = roslaunch.rlutil.get_or_generate_uuid(None, False)
parent = roslaunch.parent.ROSLaunchParent(uuid, [file], show_summary=False)
show(parent.pm, parent.server, parent.runner, parent.config, parent.logger.name, parent.force_log, parent.show_summary)
parent.start()
show(parent.pm.is_shutdown, type(parent.server).__name__, [node.args for node in parent.config.nodes])
show(xmlrpc.client.ServerProxy(parent.server.uri).list_processes()[0], parent.runner.server_uri == parent.server.uri)
end = time.monotonic() + 20
while not parent.pm.is_shutdown and time.monotonic() < end:
    time.sleep(0.05)
show(parent.pm.is_shutdown)
parent.shutdown()
os._exit(0)
"""


def test_a_launch_is_as_it_was_written(launcher: Master, package: dict[str, str]) -> None:
    lines = same_lines(launcher, SHOW + WRITTEN, package)
    assert "'/rosdistro', '/rosversion'" in lines[0] and lines[-1] == "= True"
