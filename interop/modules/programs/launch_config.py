"""roslaunch.config, roslaunch.rlutil and what the package itself has."""

import contextlib
import io
import os
import re
import sys
import tempfile
import roslaunch, roslaunch.config as config, roslaunch.core as core, roslaunch.rlutil as rlutil
from roslaunch.config import ROSLaunchConfig
from roslaunch.core import Executable, Machine, Master, Node, Param, RosbinExecutable, Test

folder = tempfile.mkdtemp(dir=os.environ["HOME"])
os.chdir(folder)


def t(title, call, *arguments, **named):
    try:
        found = repr(call(*arguments, **named))
    except Exception as error:
        found = f"{type(error).__name__}: {error}".partition("a launch file name")[0]
    print(title, re.sub(r" at 0x[0-9a-f]+", "", found).replace(folder, "FOLDER"), flush=True)


print(
    roslaunch.NAME,
    roslaunch.NUM_WORKERS,
    roslaunch.DEFAULT_MASTER_PORT,
    roslaunch.DEFAULT_TIMEOUT_SIGINT,
    roslaunch.DEFAULT_TIMEOUT_SIGTERM,
    config.DEFAULT_MASTER_PORT,
    rlutil.DEFAULT_MASTER_PORT,
    roslaunch.parent.NUM_WORKERS,
    roslaunch.parent.DEFAULT_TIMEOUT_SIGINT,
    roslaunch.parent.DEFAULT_TIMEOUT_SIGTERM,
)
for env in (None, {}, {"ROS_DISTRO": "x"}, {"ROS_DISTRO": "", "ROS_ROOT": "/r"}):
    t("loader", lambda: re.sub("/[^/]*/env.sh", "/DISTRO/env.sh", config.calculate_env_loader(env)))
t("core file", lambda: os.path.basename(config.get_roscore_filename()))
c = ROSLaunchConfig()
t(
    "new",
    lambda: (
        c.nodes,
        c.nodes_core,
        c.tests,
        c.params,
        c.clear_params,
        c.executables,
        sorted(c.machines),
        c.roslaunch_files,
        c.resolved_node_names,
        c.config_errors,
        c.master.type,
    ),
)
for p in ("/a", "b/", "/c//d", "~x", "", "/a", None, 5):
    t("clear %r" % (p,), c.add_clear_param, p)
print(c.clear_params)
for e in (Executable("a", ["b"]), RosbinExecutable("x", []), None, 5):
    t("exe", c.add_executable, e)
    print([str(x) for x in c.executables])
for f in ("a", "b", "a", "", None):
    t("file", c.add_roslaunch_file, f)
    print(c.roslaunch_files)
for m in ("text", "", None, 5):
    t("error", c.add_config_error, m)
    print(c.config_errors)
m = Master("rosmaster", "http://x:5/")
t("master", c.set_master, m)
print(c.master is m)
t("master", c.set_master, None)
c = ROSLaunchConfig()
one = Test("t1", "pkg", "type", "name", "/ns")
t("test", c.add_test, one)
t("test", c.add_test, one, verbose=False)
t("test", c.add_test, Test("t2", "p", "t"), False)
t("bad", c.add_test, Node("p", "t"))
print([type(e).__name__ for e in c.tests], c.resolved_node_names)
for name, ns, kw in (
    ("a", "/", {}),
    ("a", "/", {"verbose": False}),
    ("b", "/x", {}),
    ("b", "/y/", {"core": True}),
    (None, "/", {}),
    ("c", "rel", {"verbose": False}),
    ("c", "/rel/", {"verbose": False}),
):
    t("node", c.add_node, Node("p", "t", name, ns), **kw)
print(c.resolved_node_names, [n.name for n in c.nodes], [n.name for n in c.nodes_core])
t("node", c.add_node, None)
for p in (Param("/a", 1), Param("/a/b", 2), Param("/a", 3), Param("/c/d/e", 4), Param("/c", 5), Param("rel", 6)):
    t("param", c.add_param, p)
t("param", c.add_param, Param("/z", 1), filename="f.launch")
t("param", c.add_param, Param("/z", 2), "g.launch", False)
print({k: v.value for k, v in c.params.items()}, c.config_errors)
for m in (
    Machine("m", "localhost"),
    Machine("m", "localhost"),
    Machine("m", "other"),
    Machine("", "b"),
    Machine("n", "b", assignable=False),
):
    t("machine", c.add_machine, m)
    t("machine", c.add_machine, m, verbose=False)
print(sorted(c.machines))
t("assign", c.assign_machines)
print([n.machine and n.machine.name for n in c.nodes + c.nodes_core + c.tests])
t("remote", lambda: bool(c.has_remote_nodes()))
for known in (False, True):
    c = ROSLaunchConfig()
    c.add_node(Node("p", "t", "far", machine_name="nope"), verbose=False)
    if known:
        c.add_machine(Machine("nope", "192.0.2.1"), verbose=False)
    t("assign", c.assign_machines)
    t("remote", lambda: bool(c.has_remote_nodes()))
    print([n.machine and n.machine.address for n in c.nodes])


def summary(c, *a, **k):
    return c.summary(*a, **k).split("\n")


c = ROSLaunchConfig()
t("summary", summary, c, True)
c.add_param(Param("/p", 1), verbose=False)
c.add_param(Param("/long", "x" * 200), verbose=False)
c.add_param(Param("/multi", "a\nb"), verbose=False)
c.add_param(Param("/l", [1, 2, 3] * 40), verbose=False)
c.add_param(Param("/u", "\u00fc"), verbose=False)
for v in (True, 1.5, None, {"a": 1}, "", "  sp "):
    c.add_param(Param("/v%d" % len(c.params), v), verbose=False)
c.add_clear_param("/x")
c.add_node(Node("p", "t", "n", "/ns"), verbose=False)
c.add_node(Node("p", "t", "m"), verbose=False)
c.add_test(Test("tt", "p", "t"), False)
c.add_machine(Machine("far", "192.0.2.1"), verbose=False)
c.add_node(Node("p", "t", "c", "/ns"), core=True, verbose=False)
t("summary", summary, c)
c.assign_machines()
t("summary", summary, c)
t("local", summary, c, local=True)
loader = roslaunch.xmlloader.XmlLoader()
c = ROSLaunchConfig()


class Fake:
    def load(self, *a, **k):
        print("load", [os.path.basename(str(x)) if i == 0 else type(x).__name__ for i, x in enumerate(a)], k)


if os.path.exists(config.get_roscore_filename()):
    t("core", config.load_roscore, Fake(), c)
for n in ("/a/b/c", "/a", "/", "a/b", "a", "~x", "//a//b/", "", None, 5):
    t("ns %r" % (n,), config.namespaces_of, n)
# the package
for a in (
    (None, False, None),
    (None, True, None),
    (None, True, 5555),
    ("my.pid", False, None),
    ("my2.pid", True, 1),
    ("~/home.pid", False, None),
    ("no/such/folder", False, None),
    ("", True, 7),
):
    t("pid %s" % (a,), roslaunch.write_pid_file, *a)
print(
    sorted(os.listdir(folder)),
    sorted(n for n in os.listdir(os.environ["ROS_HOME"]) if n.endswith(".pid")),
    sorted(n for n in os.listdir(os.environ["HOME"]) if n.endswith(".pid")),
    open("my.pid").read() == str(os.getpid()),
)


class L:
    def error(self, text):
        print("logged", text.strip().split("\n")[-1])


class C:
    @staticmethod
    def printerrlog(t):
        print("printed", t)


for e in (ValueError("wrong"), KeyError("k"), roslaunch.RLException("x")):
    try:
        try:
            raise e
        except Exception as caught:
            roslaunch.handle_exception(C, L(), "before: ", caught)
    except SystemExit as ex:
        print("exit", ex.code)
open("a.launch", "w").write("<launch><arg name='x' default='1'/><param name='p' value='$(arg x)'/></launch>")
open("bad.launch", "w").write("<launch><node/></launch>")
open("b.launch", "w").write("<launch><include file='a.launch'/><arg name='need'/></launch>")
open("none.launch", "w").write("<launch><node pkg='nope_nope' type='x' name='y'/></launch>")
open("x.launch", "w").write("<launch")


class Terminal(io.StringIO):
    def isatty(self):
        return True


for arguments in ((["a.launch", "b"], False), ([], True), ([], False), (["c.launch"], False)):
    terminal = Terminal()
    with contextlib.redirect_stdout(terminal):
        rlutil.change_terminal_name(*arguments)
        rlutil.update_terminal_name("http://x:1/")
    print(repr(terminal.getvalue().replace("\n", "")))

with contextlib.redirect_stdout(io.StringIO()):
    rlutil.check_log_disk_usage()
for files in (["a.launch"], ["b.launch", "a.launch"], []):
    shown = io.StringIO()
    with contextlib.redirect_stdout(shown):
        rlutil.print_file_list(files)
    print(sorted(shown.getvalue().replace(folder, "FOLDER").splitlines()))
for f in ("bad.launch", "x.launch"):
    t("check " + f, lambda: bool(rlutil.check_roslaunch(f)))
t("check unset", lambda: bool(rlutil.check_roslaunch("none.launch", ignore_unset_args=True)))
t("check ok", rlutil.check_roslaunch, "a.launch")
for a in (
    ["a.launch"],
    ["a.launch", "b.launch", "x:=1"],
    ["nowhere.launch"],
    [],
    ["x:=1"],
    ["-"],
    ["nope_nope", "a.launch"],
    ["roslaunch", "nope.launch"],
    ["."],
):
    t("resolve %s" % a, rlutil.resolve_launch_arguments, a)
t("uuid", rlutil.get_or_generate_uuid, "given", False)
t("uuid", rlutil.get_or_generate_uuid, "given", True)
t("uuid", lambda: rlutil.get_or_generate_uuid(None, False) == rlutil.get_or_generate_uuid("", True))
