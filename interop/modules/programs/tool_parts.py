"""rostopic, rosnode, rosservice, rosparam and rosmsg: what other tools take from them."""

import contextlib
import io
import os
import re
import sys
import tempfile
import time
import yaml
import genpy
import rosgraph
import rosmsg
import rosnode
import rosparam
import rospy
import rosservice
import rostopic
import rospkg
from geometry_msgs.msg import PoseStamped
from std_msgs.msg import String, Header
from sensor_msgs.msg import LaserScan
from xmlrpc.client import Binary

os.chdir(tempfile.mkdtemp(dir=os.environ["HOME"]))


def t(title, call, *arguments, **named):
    try:
        found = repr(call(*arguments, **named))
    except SystemExit as error:
        found = f"exit {error.code}"
    except Exception as error:
        found = f"{type(error).__name__}: {error}"
    print(title, re.sub(r" at 0x[0-9a-f]+", "", found), flush=True)


def stdin(text):
    reading, writing = os.pipe()
    with os.fdopen(writing, "w") as file:
        file.write(text)
    sys.stdin = os.fdopen(reading)


# exceptions
for cls in (
    rosnode.ROSNodeException,
    rosnode.ROSNodeIOException,
    rosservice.ROSServiceException,
    rosservice.ROSServiceIOException,
    rosmsg.RosMsgProtoException,
    rosmsg.RosMsgProtoArgsException,
    rostopic.ROSTopicException,
    rostopic.ROSTopicIOException,
    rosparam.RosParamException,
    rosmsg.ROSMsgException,
):
    print([c.__name__ for c in cls.__mro__])

    def raises():
        raise cls("text")

    t("raise", raises)


# rosparam
class L:
    def represent_scalar(self, *a, **k):
        return ("scalar", a, k)

    def represent_binary(self, d):
        return ("B", d)

    def represent_str(self, d):
        return ("S", d)


t("foo", rosparam.represent_foo, L(), 5)
t("foo", rosparam.represent_foo, yaml.SafeDumper(io.StringIO()), "x")
for text in (
    "!!binary AAE=",
    "rad(pi)",
    "deg(90)",
    "!radians pi/2",
    "!degrees 180",
    "rad(2*pi/3)",
    "deg()",
    "[rad(1), deg(1)]",
    "rad(1",
    "'rad(1)'",
    "!degrees rad(1)",
    " deg( 45 ) ",
    "rad()",
    "rad(1 +)",
    "deg(1.5e1)",
    "!radians 3",
):
    t("yaml " + text, lambda: (lambda v: v.data if isinstance(v, Binary) else v)(yaml.safe_load(text)))


class N:
    def __init__(self, v):
        self.value = v


class Lo(yaml.SafeLoader):
    pass


lo = Lo("x")
for v in ("", "1e3", "5", "rad(", "3 +"):
    n = yaml.ScalarNode("tag", v)
    t("rad %s" % v, rosparam.construct_angle_radians, lo, n)
    t("deg %s" % v, rosparam.construct_angle_degrees, lo, n)
t("binary", lambda: rosparam.construct_yaml_binary(lo, yaml.ScalarNode("tag", "AAE=")).data)
t("binary", lambda: rosparam.construct_yaml_binary(lo, yaml.ScalarNode("tag", "A")).data)
s = rosparam.get_param_server()
t("server", lambda: (type(s).__name__, s.getParamNames()[0] if 0 else s.hasParam("/nope")))
t("same", lambda: rosparam.get_param_server() is s)
t("caller", lambda: s.caller_id.split("-")[0] if hasattr(s, "caller_id") else None)


def shown(call, *a, argv=()):
    sys.argv[1:] = list(argv)
    out = io.StringIO()
    err = io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            r = call(*a)
        except SystemExit as e:
            r = "exit %s" % e.code
        except Exception as e:
            r = f"{type(e).__name__}: {e}"
    print(call.__name__, a, r, out.getvalue().split("\n"), err.getvalue()[-200:].split("\n"))


for mode in (rosmsg.MODE_MSG, rosmsg.MODE_SRV):
    for w in [["std_msgs/String"], ["nope/Nope"]] if mode == rosmsg.MODE_MSG else [["std_srvs/SetBool"]]:
        shown(rosmsg.rosmsg_cmd_md5, mode, "", argv=["md5", *w])
    for w in (
        ["std_srvs"],
        ["std_srvs", "-s"],
        ["-s", "actionlib_msgs"],
    ):
        shown(rosmsg.rosmsg_cmd_package, mode, "", argv=["package", *w])
ctx = rosmsg.genmsg.MsgContext.create_default() if hasattr(rosmsg, "genmsg") else None
import genmsg

sp = rospkg.RosPack()
ctx = genmsg.MsgContext.create_default()
search = {p: [os.path.join(sp.get_path(p), "msg")] for p in ("std_msgs", "geometry_msgs")}
spec = genmsg.load_msg_by_type(ctx, "geometry_msgs/PoseStamped", search)
genmsg.load_depends(ctx, spec, search)
t("spec", rosmsg.spec_to_str, ctx, spec)
b = io.StringIO()
t("spec", rosmsg.spec_to_str, ctx, spec, b, ">")
print(b.getvalue())
c = genmsg.msg_loader.load_msg_from_string(ctx, "int32 X=5\nstring S= hi # no\nfloat32[3] f\nHeader h\n", "a/B")
t("spec", rosmsg.spec_to_str, ctx, c)
# rosnode
rospy.init_node("observed", anonymous=False)
shown(rosnode.rosnode_info, "/not_there")
out = io.StringIO()
end = time.monotonic() + 20
while "to: /rosout" not in out.getvalue() and time.monotonic() < end:
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        rosnode.rosnode_info("/observed")
print(re.sub(r"[0-9]+", "N", out.getvalue()))
shown(rosnode.rosnode_info, "relative_nope")
# rostopic
h = rostopic.ROSTopicHz(5)
for f in (h.set_last_printed_tn, h.set_msg_t0, h.set_msg_tn):
    t("set", f, 5.0)
    t("set", f, 6.0, "/topic")
    t("set", f, value=7.0, topic="/t2")
t("times", h.set_times, [1.0, 2.0])
t("times", h.set_times, [3.0], "/topic")
t("get", lambda: (h.last_printed_tn, h.msg_t0, h.msg_tn, h.times))
t(
    "get",
    lambda: (h.get_last_printed_tn("/topic"), h.get_msg_t0("/topic"), h.get_msg_tn("/topic"), h.get_times("/topic")),
)
t("get", lambda: (h.get_last_printed_tn(), h.get_msg_t0(), h.get_msg_tn(), h.get_times()))
t("get", lambda: (h.get_last_printed_tn("/none"), h.get_msg_t0("/none"), h.get_msg_tn("/none"), h.get_times("/none")))
t("none", h.set_times, 5)
e = rostopic.CallbackEcho("/t", None)
m = PoseStamped()
m.pose.position.x = 1.23456789
for k in (
    {},
    {"indent": "  "},
    {"time_offset": rospy.Time(5)},
    {"fixed_numeric_width": 10},
    {"current_time": rospy.Time(3)},
    {"field_filter": rostopic.create_field_filter(True, True)},
):
    t("str %s" % sorted(k), lambda: e.custom_strify_message(m, **k))
    t("str", lambda: e.custom_strify_message(5, **k))
ev = rostopic.CallbackEcho("/t", None, fixed_numeric_width=7)
t("ev", ev.custom_strify_message, LaserScan(ranges=[1, 2]))
t("ev", ev.custom_strify_message, [1, 2], type_information="float32[]")
t("ev", ev.custom_strify_message, "abc", type_information="string")
t("ev", ev.custom_strify_message, "abc")
t("none", ev.custom_strify_message, None)
# publishing
heard = []
sub = rospy.Subscriber("/pub_topic", String, lambda m: heard.append(m.data))
pub = rospy.Publisher("/pub_topic", String, queue_size=10, latch=True)
end = time.monotonic() + 30
while not pub.get_num_connections() and time.monotonic() < end:
    time.sleep(0.01)


def wait(n):
    end = time.monotonic() + 30
    while len(heard) < n and time.monotonic() < end:
        time.sleep(0.01)
    print(sorted(heard))
    heard.clear()


with open("file.yaml", "w") as file:
    file.write("data: f1\n---\ndata: f2\n")
for name, verbose in ((None, True), ("file.yaml", False)):
    stdin("data: one\n---\n[two]\n---\ndata: three\n---\n")
    with contextlib.redirect_stdout(io.StringIO()):
        rostopic.stdin_publish(pub, String, 50, False, name, verbose)
    wait(2 if name else 3)
rospy.signal_shutdown("enough")
print(rosmsg.fullusage(rosmsg.MODE_MSG), rosmsg.fullusage(rosmsg.MODE_SRV))
