"""Names of roslaunch.core: masters, machines, executables, printing, environments."""

import getpass
import os
import re
import sys

import roslaunch
import roslaunch.core as core
from roslaunch.core import Machine, Master, Node

here = {os.uname().nodename: "HERE"}


def t(title, call, *arguments, **named):
    try:
        found = str(call(*arguments, **named))
    except Exception as error:
        found = f"{type(error).__name__}: {error}"
    for name in here:
        found = found.replace(name, "HERE")
    print(title, re.sub(r" at 0x[0-9a-f]+", "", found))


# Masters
os.environ["ROS_HOSTNAME"] = "localhost"
print(Master.ROSMASTER, Master.ZENMASTER)
for arguments in (
    (),
    ("rosmaster",),
    ("zenmaster",),
    ("other", "http://somewhere.invalid:123/"),
    (None, "http://a"),
    (None, "http://a:x/"),
    (None, ""),
    (None, "nonsense"),
    (None, "http://a:80/", 1),
    ("", "http://b:8"),
):
    try:
        master = Master(*arguments)
    except Exception as error:
        print(arguments, type(error).__name__, error)
        continue
    print(arguments, master.type, master.uri.replace(os.environ["ROS_MASTER_URI"].rstrip("/"), "URI"), master.auto)
    t("host", master.get_host)
    t("port", lambda: master.get_port() if arguments[1:] else "PORT")
    t("get", lambda: type(master.get()).__name__)
    t("multi", lambda: type(master.get_multi()).__name__)
    t("same", lambda: (master == Master(*arguments), master == Master(), master == 5))
t("running", Master().is_running)
t("not running", Master(uri="http://localhost:1/").is_running)
multi = Master().get_multi()
multi.getParam("/asker", "/no/such/parameter")
multi.lookupNode("/asker", "/no_such_node")
t("multi answers", lambda: [answer[0] for answer in multi()])

# Machines
for arguments, named in (
    (("a", "b"), {}),
    (("a", "b", "loader", 23, "me", "word", False), {}),
    (("a", "b"), {"timeout": 3}),
    (("a", "b"), {"timeout": 0}),
    (("", "localhost"), {}),
    (("a", "b"), {"user": "", "password": ""}),
    (("a", None), {}),
    (("a", "b"), {"env_args": [("x", "y")]}),
    (("a", "b"), {"ssh_port": "77"}),
):
    machine = Machine(*arguments, **named)
    print(
        machine.name,
        machine.address,
        machine.env_loader,
        machine.ssh_port,
        machine.user,
        machine.password,
        machine.assignable,
        machine.timeout,
    )
    t("key", machine.config_key)
    t("text", str, machine)
    t(
        "equals",
        lambda: (
            machine.config_equals(Machine("other", "b")),
            machine == Machine("a", "b"),
            machine != Machine("a", "b"),
        ),
    )
    t("with", machine.config_equals, 5)
    t("equal to", lambda: machine == 5)
    t("local", core.is_machine_local, machine)
for address in (
    "localhost",
    "127.0.0.1",
    "::1",
    "127.0.0.2",
    os.uname().nodename,
    "no-such-host.invalid",
    "",
    "192.0.2.1",
):
    t("local " + address, core.is_machine_local, Machine("m", address))
t("user", lambda: core.is_machine_local(Machine("m", "localhost", user="somebody-else")))
t("user", lambda: core.is_machine_local(Machine("m", "localhost", ssh_port=2222)))
t("this", lambda: (str(core.local_machine()), core.local_machine() is core.local_machine()))
t("none", core.is_machine_local, None)

# Executables
print(core.PHASE_SETUP, core.PHASE_RUN, core.PHASE_TEARDOWN)
for made in (
    core.Executable("cmd", ["a", "b"]),
    core.Executable("cmd", [], core.PHASE_SETUP),
    core.RosbinExecutable("x", ("y",)),
    core.RosbinExecutable("x", (), phase="odd"),
):
    print(made.command, made.args, made.phase, str(made), repr(made), isinstance(made, core.Executable))
t("wrong", lambda: str(core.Executable("x", None)))
t("wrong", lambda: str(core.Executable("x", "words")))
t("few", core.Executable)

# Addresses
for uri in (
    "http://localhost:11311",
    "http://localhost:11311/",
    "http://127.0.0.1:5/",
    "http://elsewhere.invalid:7/x",
    "http://localhost",
    "nonsense",
    "",
    "http://HERE:9/".replace("HERE", os.uname().nodename),
    "http://localhost:5/path",
):
    t("remap " + repr(uri.replace(os.uname().nodename, "HERE")), core.remap_localhost_uri, uri)
    t("forced", core.remap_localhost_uri, uri, True)
    t("forced", core.remap_localhost_uri, uri, force_localhost=True)
t("none", core.remap_localhost_uri, None)
for value in ("http://localhost:22/", "http://localhost:22", "http://far.invalid:33/"):
    os.environ["ROS_MASTER_URI"] = value
    t("environment " + value, core.get_master_uri_env)
for host in ("myself", None):
    os.environ["ROS_MASTER_URI"] = "http://localhost:44/"
    os.environ.pop("ROS_HOSTNAME", None)
    if host:
        os.environ["ROS_HOSTNAME"] = host
    t("named", core.get_master_uri_env)
    t("named", core.remap_localhost_uri, "http://localhost:4/")
for value in ("", "/x:/y", None):
    os.environ.pop("ROS_ROOT", None)
    if value is not None:
        os.environ["ROS_ROOT"] = value
    t("root", core.get_ros_root)

# Environments of nodes
for node in (
    Node("p", "t", "n"),
    Node("p", "t", "n", "/a/b/"),
    Node("p", "t", "n", "/a", env_args=[("X", "1"), ("Y", "2")]),
    Node("p", "t", env_args=[("ROS_MASTER_URI", "mine"), ("ROS_NAMESPACE", "mine")]),
    None,
):
    for env in ({}, {"ROS_NAMESPACE": "old", "PATH": "p", "PYTHONPATH": "q"}, {"ROS_IP": "1.2.3.4", "ROS_ROOT": "r"}):
        for machine in (core.local_machine(), Machine("m", "far.invalid", "loader"), None):
            before = dict(env)
            t("env", lambda: sorted(core.setup_env(node, machine, "http://localhost:5/", env).items()))
            print(env == before)
t("own", lambda: {**core.setup_env(None, None, "uri")} == {**os.environ, "ROS_MASTER_URI": "uri"})


# Printing
def prefix(word):
    return lambda text: sys.stdout.write(f"{word}<{text}>\n")


core.clear_printlog_handlers()
core.clear_printerrlog_handlers()
core.printlog("nobody sees it")
core.printerrlog("nor this")
core.add_printlog_handler(prefix("one"))
core.add_printlog_handler(prefix("two"))
core.add_printerrlog_handler(prefix("error"))
core.printlog("plain")
core.printlog_bold("bold")
core.printerrlog("wrong")
core.printlog("two\nlines")
core.printlog(5)
t("raising", lambda: (core.add_printlog_handler(lambda text: 1 / 0), core.printlog("x")))
core.clear_printlog_handlers()
t("not callable", lambda: (core.add_printlog_handler(5), core.printlog("x")))
core.clear_printlog_handlers()
print(core.is_child_mode())
core.set_child_mode(True)
print(core.is_child_mode())
core.printlog("in a child")
core.set_child_mode(False)
print(core.is_child_mode())


def works(a, b=2):
    "Adds."
    return a + b


def fails():
    raise ValueError("in the body")


class Refuses(roslaunch.RLException):
    pass


def refuses():
    raise Refuses("refused")


wrapped = core.rle_wrapper(works)
t("wrapped", wrapped, 1, b=5)
t("name", lambda: wrapped.__name__)
t("too many", wrapped, 1, 2, 3)
for function in (fails, refuses):
    t("wrapped", core.rle_wrapper(function))

# Handlers that fail, and texts that are none
core.add_printerrlog_handler(prefix("error"))


def raises(text):
    print("called")
    raise ValueError


core.add_printlog_handler(raises)
core.add_printlog_handler(prefix("after"))
for function in (core.printlog, core.printlog_bold, core.printerrlog):
    for text in ("text", None, 7, "\u00fc"):
        function(text)
core.set_child_mode(5)
print(core.is_child_mode())
core.printerrlog("child")

# Addresses once more
URIS = """http://localhost:44/ http://myself:3 http://127.0.0.1:8 https://localhost:1/x?y#z HTTP://LOCALHOST:5/ localhost:5
http://u:p@localhost:7/ http://localhost:0 http://localhost: http://[::1]:5/ rosrpc://localhost:5 http:///x""".split()
for host in (None, "myself", "localhost"):
    for ip in (None, "192.0.2.9"):
        for name, value in (("ROS_HOSTNAME", host), ("ROS_IP", ip)):
            os.environ.pop(name, None)
            if value:
                os.environ[name] = value
        for uri in URIS:
            t(f"{host} {ip} {uri}", core.remap_localhost_uri, uri)
            t("forced", core.remap_localhost_uri, uri, True)
            os.environ["ROS_MASTER_URI"] = uri
            t("environment", core.get_master_uri_env)
for value in (None, "", "x"):
    os.environ.pop("ROS_MASTER_URI", None)
    if value is not None:
        os.environ["ROS_MASTER_URI"] = value
    t("environment", core.get_master_uri_env)
for address in ("localhost", None, "nowhere.invalid"):
    for user in (None, "", getpass.getuser(), "other"):
        t(f"user of {address}", core.is_machine_local, Machine("x", address, user=user))
