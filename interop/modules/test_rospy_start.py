"""rospy before and at the start of a node, names and parameters: the same program on stock's modules and on ours
(P01, P02, P06, P07, P10, P22-P28, P37, N07-N17)."""

from __future__ import annotations

import pytest
from faces import run, same
from harness import Master
from rospy_programs import TOOLS

HEAD = "import rospy\n" + TOOLS

BEFORE = """
for name in ("get_name", "get_namespace", "get_caller_id", "get_node_uri", "is_shutdown", "get_ros_root", "get_time",
             "get_rostime", "spin"):
    t(name, getattr(rospy, name))
t("now", rospy.Time.now)
t("rate", lambda: rospy.Rate(10))
t("sleep", lambda: (rospy.sleep(0.001), rospy.sleep(rospy.Duration(0, 1000)), rospy.sleep(-1)))
for name in ("a", "~a", "/a//b/", "", "a b", "/", "a/"):
    t("resolve", lambda: rospy.resolve_name(name))
    t("resolve", lambda: rospy.resolve_name(name, "/n/x"))
    t("remap", lambda: (rospy.remap_name(name), rospy.remap_name(name, resolved=False)))
t("get_param", lambda: rospy.get_param("nope"))
t("get_param", lambda: rospy.get_param("~nope"))
t("get_param", lambda: rospy.get_param("nope", 3))
t("has", lambda: rospy.has_param("nope"))
t("search", lambda: (rospy.search_param("nope"), rospy.search_param("/nope"), rospy.search_param("")))
t("delete", lambda: rospy.delete_param("nope"))
t("published", lambda: rospy.get_published_topics("/nowhere"))
publisher = rospy.Publisher("x", String, queue_size=1)
t("publish", lambda: publisher.publish("x"))
t("connections", publisher.get_num_connections)
for name, data_class in ((None, String), ("", String), (1, String), ("x", None), ("x", 1), ("x", int), ("~x", String)):
    t("Publisher", lambda: rospy.Publisher(name, data_class, queue_size=1).resolved_name)
    t("Subscriber", lambda: rospy.Subscriber(name, data_class).resolved_name)
t("queue", lambda: rospy.Publisher("x", String, queue_size=-1).impl.ref_count)
t("queue", lambda: rospy.Publisher("x", String, queue_size=1, headers={"a": 5}).impl.ref_count)
t("queue", lambda: rospy.Subscriber("x", String, queue_size=0))
t("queue", lambda: rospy.Subscriber("x", String, queue_size=-1).impl.queue_size)
t("queue", lambda: rospy.Subscriber("x", String, lambda m: 1, None, "a"))
t("buffer", lambda: rospy.Subscriber("x", String, buff_size=0))
t("service", lambda: rospy.Service("s1", Empty, lambda r: 1).resolved_name)
t("service", lambda: rospy.Service("s1", Empty, lambda r: 1))
t("service", lambda: rospy.Service("", Empty, None))
t("service", lambda: rospy.Service(1, Empty, None))
t("service", lambda: rospy.Service("s2", String, None))
t("proxy", lambda: rospy.ServiceProxy("nowhere", Empty)())
t("wait", lambda: rospy.wait_for_service("nowhere", 0.1))
t("wait", lambda: rospy.wait_for_service("nowhere", rospy.Duration(0.1)))
t("wait", lambda: rospy.wait_for_service("nowhere", 0))
for uri in ("rosrpc://a:12", "http://a:12", "rosrpc://a", ""):
    t("parse", lambda: rospy.parse_rosrpc_uri(uri))
t("root", lambda: rospy.get_ros_root(True))
t("root", lambda: rospy.get_ros_root(required=True, env={"ROS_ROOT": "/x"}))
t("hook", lambda: rospy.on_shutdown(5))
t("clock", lambda: (rospy.rostime.is_wallclock(), rospy.rostime.is_rostime_initialized()))
t("myargv", lambda: rospy.myargv(["p", "a:=b", "_x:=1", "__name:=n", "x", "a:=", "-x:=3", ":=4", "1:=2", "a b:=c",
                                  "~p:=1", "http://x:=y", "a-b:=c", "--x=a:=b"]))
for name in ("a/b", "", None):
    t("init", lambda: rospy.init_node(name))
t("log", lambda: rospy.loginfo("nobody sees it"))
t("core", lambda: (rospy.core.is_initialized(), rospy.core.is_shutdown_requested(), rospy.core._in_shutdown))
t("names", lambda: (rospy.names.namespace("/a/b"), rospy.names.ns_join("/a", "b"), rospy.names.ns_join("/a", "/b")))
t("scoped", lambda: (rospy.names.scoped_name("/a/n", "/a/b"), rospy.names.scoped_name("/n", "/c/d")))
"""

COMMAND_LINE = """
t("before", lambda: (rospy.get_name(), rospy.get_namespace(), rospy.resolve_name("a"), rospy.remap_name("a")))
rospy.init_node("given")
t("name", lambda: (rospy.get_name(), rospy.get_namespace(), rospy.get_caller_id()))
t("resolve", lambda: [rospy.resolve_name(name) for name in ("a", "/a", "~a", "b", "~z", "other/a", "c")])
t("remap", lambda: [rospy.remap_name(name) for name in ("a", "/a", "b", "~z")])
t("mappings", lambda: sorted(rospy.names.get_mappings().items()))
t("mappings", lambda: sorted(rospy.names.get_resolved_mappings().items()))
t("private", lambda: sorted(rospy.get_param("~").items()))
t("myargv", lambda: rospy.myargv()[1:])
publisher = rospy.Publisher("a", String, queue_size=1)
service = rospy.Service("c", Empty, lambda request: [])
t("topic", lambda: (publisher.resolved_name, service.resolved_name))
t("master", lambda: rospy.get_published_topics("/ns"))
t("param", lambda: (rospy.set_param("c", 5), rospy.get_param("/ns/d/e"), rospy.get_param("c"), rospy.search_param("c")))
"""
ARGUMENTS = "plain a:=b _int:=5 _f:=2.5 _text:=hello _yes:=true _list:=[1,2,x] __ns:=/ns c:=d/e __name:=new ~z:=/zz"

VALUES = r"""
texts = ["1", "-1", "+1", "01", "0x10", "0o17", "1_000", "1e3", "1.5", ".5", "1.", "1e400", "-.inf", "true", "yes", "Off",
         "tRue", "null", "~", "NULL", "---", "#c", "a #c", "y", "=", "hello", "two words", " x ", "deg(90)", "rad(pi/2)",
         "1pi", "[1,2", "[1, 2, x]", "[]", "{a: {b: [1, 2]}}", "{a: null}", "{1: 2}", "{true: 2}", "{<<: {a: 1}, b: 2}",
         "<<: 1", "a: b", "a: b: c", "- 1", "?", "|", "!x y", "!!str 5", "!!int x", "!!bool x", "!!set {a}",
         "!!binary aGVsbG8=", "!!python/object:os.system x", "*x", "[&x 1, *x]", "&a [1, *a]", '"a', "%x", "@x", "`x`",
         "2147483647", "2147483648", "-2147483649", "12:30:45", "2026-01-01", "a\x01b", "\u00e4", "\U0001f600", "http://x:1",
         "a:=b", "1\n2", '""', "\t"]
rospy.init_node("values", [])
for text in texts:
    try:
        values = rospy.client.load_command_line_node_params(["_p:=" + text])
    except rospy.ROSInitException as error:
        print(repr(text), "!!", "not YAML" if ":=" in text else str(error))
        continue
    for name, value in values.items():
        try:
            rospy.set_param("~" + name, value)
        except (TypeError, OverflowError) as error:
            print(repr(text), type(error).__name__)
        else:
            kept = rospy.get_param("~" + name)
            print(repr(text), repr(getattr(kept, "data", kept)))
"""
REFUSED = """
try:
    rospy.init_node("refused", disable_signals=True)
except Exception as error:
    print(type(error).__name__)
print(rospy.core.is_initialized(), rospy.has_param("/refused/p"))
os._exit(0)
"""

AGAIN = """
rospy.init_node("again", ["p", "q:=r"], log_level=rospy.WARN)
t("again", lambda: rospy.init_node("again", ["p", "q:=r"], log_level=rospy.WARN))
t("rosout", lambda: rospy.init_node("again", ["p", "q:=r"], log_level=rospy.WARN, disable_rosout=True))
for other in (dict(name="b"), dict(anonymous=True), dict(disable_signals=True), dict(log_level=None), dict(argv=[])):
    t("other", lambda: rospy.init_node(**{**dict(name="again", argv=["p", "q:=r"], log_level=rospy.WARN), **other}))
t("argv", lambda: rospy.resolve_name("q"))
t("level", lambda: rospy.init_node("again", log_level=3))
"""

ANONYMOUS = """
rospy.init_node("many", anonymous=True)
base, pid, millis = rospy.get_name().rsplit("_", 2)
print(base, pid == str(os.getpid()), abs(int(millis) / 1000 - time.time()) < 100)
print(rospy.get_node_uri().startswith("http://localhost:"))
"""

PARAMETERS = """
rospy.init_node("params")
master = rospy.get_master()
t("tree", lambda: (rospy.set_param("tree", {"a": 1, "b": [1, 2.5, "x", True], "c": {"d": "e"}}),
    rospy.get_param("tree")))
t("leaf", lambda: (rospy.get_param("/tree/b"), rospy.get_param("tree/c/d"), rospy.has_param("tree/c"),
    rospy.has_param("tr")))
t("delete", lambda: (rospy.delete_param("tree/c"), rospy.get_param("tree")))
t("delete", lambda: rospy.delete_param("tree/c"))
t("private", lambda: (rospy.set_param("~p", 3), rospy.get_param("~p"), rospy.get_param("/params/p"),
    rospy.search_param("p")))
t("cached", lambda: rospy.get_param_cached("nope"))
t("cached", lambda: rospy.get_param_cached("nope", 5))
t("cached", lambda: rospy.get_param_cached("~p"))
rospy.set_param("~p", 4)
t("cached", lambda: (rospy.get_param_cached("~p"), rospy.get_param("~p"), rospy.get_param("~p", 7)))
t("names", lambda: [name for name in sorted(rospy.get_param_names()) if name.startswith(("/params", "/tree"))])
for bad in (None, object(), {1: 2}, 2**40):
    try:
        rospy.set_param("bad", bad)
    except (TypeError, OverflowError) as error:
        print(type(error).__name__)
t("proxy", lambda: (master.getPid()[:2], master.getParam("nope"), master.hasParam("~p"), master.lookupService("/nope")))
t("proxy", lambda: ("nope" in master, "~p" in master, master["~p"], master.search_param("p"),
    master.search_param("nope")))
t("proxy", lambda: master["nope"])
def change():
    master["mine"] = 4
    inside = master["mine"], [name for name in master if name.endswith("/mine")]
    del master["mine"]
    return inside, "mine" in master
t("proxy", change)
t("proxy", lambda: master.get_param_cached("nope"))
t("kind", lambda: (type(master).__name__, isinstance(master, rospy.MasterProxy)))
t("uri", lambda: master.lookupNode("/params")[2] == rospy.get_node_uri())
for name in ("tree", "~p"):
    rospy.delete_param(name)
"""

NO_MASTER = """
for call in (lambda: rospy.get_param("x", 1), lambda: rospy.set_param("x", 1), lambda: rospy.get_master().getPid()):
    try:
        call()
    except OSError as error:
        print("OSError")
"""


def test_before_there_is_a_node(launcher: Master) -> None:
    assert "init_node()" in same(launcher, HEAD + BEFORE)


def test_command_line(launcher: Master) -> None:
    said = same(launcher, HEAD + COMMAND_LINE, *ARGUMENTS.split(" "))
    assert "/ns/new" in said and "('int', 5)" in said


def test_values_of_private_parameters(launcher: Master) -> None:
    said = same(launcher, HEAD + VALUES)
    assert "'deg(90)' 'deg(90)'" in said and "'null' TypeError" in said and "'[1,2' !!" in said


@pytest.mark.parametrize(
    ("value", "error"),
    [
        ("[1,2", "ROSInitException"),
        ("null", "TypeError"),
        ("2147483648", "OverflowError"),
        ("a:=b", "ROSInitException"),
    ],
)
def test_a_private_parameter_that_cannot_be_ends_init_node(launcher: Master, value: str, error: str) -> None:
    assert same(launcher, HEAD + REFUSED, f"_p:={value}") == f"{error}\nFalse False\n"


def test_init_node_twice(launcher: Master) -> None:
    assert same(launcher, HEAD + AGAIN).count("different arguments") == 6


def test_anonymous(launcher: Master) -> None:
    assert same(launcher, HEAD + ANONYMOUS) == "/many True True\nTrue\n"


def test_parameters(launcher: Master) -> None:
    assert "KeyError" in same(launcher, HEAD + PARAMETERS)


def test_environment(launcher: Master) -> None:
    text = (
        HEAD + "print(rospy.resolve_name('a')); rospy.init_node('n'); print(rospy.get_name(), rospy.resolve_name('a'))"
    )
    assert same(launcher, text, ROS_NAMESPACE="robot") == "/robot/a\n/robot/n /robot/a\n"


def test_without_a_master(launcher: Master) -> None:
    for face in ("stock", "ours"):
        assert run(face, launcher, HEAD + NO_MASTER, ROS_MASTER_URI="http://localhost:1") == "OSError\n" * 3
