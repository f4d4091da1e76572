"""tf2_ros: registries of conversions and transformations, the buffer's core, listeners' callbacks."""

import sys
import re
import rospy
import tf2_ros
from tf2_ros import *
from geometry_msgs.msg import TransformStamped, PointStamped, Vector3Stamped
from tf2_msgs.msg import TFMessage


def t(title, call, *arguments, **named):
    try:
        found = str(call(*arguments, **named))
    except Exception as error:
        found = f"{type(error).__name__}: {error}"
    print(title, re.sub(r" at 0x[0-9a-f]+", "", found).replace("\n", "|"), flush=True)


print(tf2_ros.DEFAULT_CAN_TRANSFORM_POLLING_SCALE)
T = rospy.Time


def w(call, *arguments):
    """Call with wrong arguments; the texts of these errors are Python's."""
    try:
        print("wrong", call(*arguments))
    except Exception as error:
        print("wrong", type(error).__name__)


for cls in (
    tf2_ros.InvalidArgumentException,
    tf2_ros.ConnectivityException,
    tf2_ros.LookupException,
    tf2_ros.ExtrapolationException,
    tf2_ros.TimeoutException,
    tf2_ros.TransformException,
    tf2_ros.TypeException,
    tf2_ros.NotImplementedException,
):
    print([c.__name__ for c in cls.__mro__ if c.__name__ != "Error"])
    t("x", lambda: str(cls("text")))
C = tf2_ros.ConvertRegistration()
R = tf2_ros.TransformRegistration()
t("missing", C.get_to_msg, int)
t("missing", C.get_from_msg, int)
t("missing", C.get_convert, (int, str))
t("missing", R.get, int)
t("print", R.print_me)
t("add", C.add_to_msg, int, lambda x: "to %s" % x)
t("add", C.add_from_msg, int, lambda x: int(x.split()[1]))
t("add", C.add_convert, (int, str), lambda x: "c %d" % x)
t("add", R.add, int, lambda a, b: (a, b))
t("get", lambda: C.get_to_msg(int)(5))
t("get", lambda: C.get_from_msg(int)("to 6"))
t("get", lambda: C.get_convert((int, str))(7))
t("get", lambda: R.get(int)(1, 2))
t("get other", lambda: tf2_ros.TransformRegistration().get(int)(3, 4))
t("get", tf2_ros.ConvertRegistration().get_to_msg, float)
t("unhash", R.get, [])
t("conv", tf2_ros.convert, 5, str)
t("conv", tf2_ros.convert, 5, float)
t("conv", tf2_ros.convert, 5, int)
t("conv", tf2_ros.convert, "x", int)


class S(str):
    pass


C.add_to_msg(S, lambda x: 9)
t("conv", tf2_ros.convert, S("a"), int)


class BB(tf2_ros.BufferInterface):
    def lookup_transform(self, *a, **k):
        print("lookup", a[:2], k)
        return "tr"

    def lookup_transform_full(self, *a, **k):
        print("full", a[:2], k)
        return "trf"


b = tf2_ros.BufferInterface()
for n, a in (
    ("lookup_transform", ("a", "b", T(0))),
    ("lookup_transform_full", ("a", T(0), "b", T(0), "c")),
    ("can_transform", ("a", "b", T(0))),
    ("can_transform_full", ("a", T(0), "b", T(0), "c")),
):
    t(n, getattr(b, n), *a)
b = BB()
t("tr", b.transform, 5, "target")
t("tr", b.transform, PointStamped(), "target")
t("full", b.transform_full, 5, "target", T(1), "fixed")


def legal(answer, frames):
    """Return what `can_transform` answers; without the reason, which stock does not know, if a frame's name is wrong."""
    return answer if {*frames} <= {*"abcdxy"} else answer[0]


def tr(parent, child, sec, x, q=(0, 0, 0, 1)):
    m = TransformStamped()
    m.header.frame_id = parent
    m.child_frame_id = child
    m.header.stamp = T(sec)
    m.transform.translation.x = x
    m.transform.rotation.x, m.transform.rotation.y, m.transform.rotation.z, m.transform.rotation.w = q
    return m


for make in (lambda: tf2_ros.BufferCore(rospy.Duration(10)), lambda: tf2_ros.Buffer(rospy.Duration(10), debug=False)):
    b = make()
    print(type(b).__name__)
    t("empty", b.all_frames_as_string)
    t("empty", b.all_frames_as_yaml)
    for m in (tr("a", "b", 1, 1.0), tr("a", "b", 3, 3.0), tr("b", "c", 2, 5.0), tr("b", "c", 4, 5.0)):
        t("set", b.set_transform, m, "me")
    t("static", b.set_transform_static, tr("c", "d", 0, 7.0), "me")
    t("set", b.set_transform, tr("x", "y", 1, 1), "other")
    t("string", b.all_frames_as_string)
    t("yaml", lambda: sorted(b.all_frames_as_yaml().split("\n")))
    for p in (
        ("a", "b"),
        ("a", "c"),
        ("c", "a"),
        ("d", "a"),
        ("a", "y"),
        ("a", "nope"),
        ("nope", "a"),
        ("c", "d"),
        ("a", "a"),
        ("", "a"),
        ("a", ""),
        ("/a", "b"),
    ):
        if p != ("a", "y"):  # ours is of a class below stock's
            t("common %s" % (p,), b.get_latest_common_time, *p)
        for s in (0, 1, 2, 2.5, 3, 9):
            t("core %s %s" % (p, s), lambda: b.lookup_transform_core(p[0], p[1], T.from_sec(s)).transform.translation.x)
            t("can", lambda: legal(b.can_transform_core(p[0], p[1], T.from_sec(s)), p))
    for a in (
        ("a", T(2), "c", T(3), "b"),
        ("a", T(2), "c", T(3), "a"),
        ("a", T(0), "b", T(0), "c"),
        ("a", T(2), "c", T(3), "nope"),
        ("a", T(9), "c", T(3), "b"),
        ("a", T(2), "y", T(3), "b"),
        ("nope", T(2), "c", T(3), "b"),
        ("a", T(2), "c", T(3), ""),
    ):
        t("full", lambda: b.lookup_transform_full_core(*a).transform.translation.x)
        t("can", lambda: legal(b.can_transform_full_core(*a), (a[0], a[2], a[4])))
    for a in ((), ("a",), ("a", "b"), (1, "b", T(0)), ("a", "b", 5), ("a", "b", None), ("a", "b", T(0), 1)):
        w(b.lookup_transform_core, *a)
        w(b.can_transform_core, *a)
        w(b.lookup_transform_full_core, *a)
    w(b.get_latest_common_time, "a")
    w(b.get_latest_common_time, 1, 2)
    w(b.all_frames_as_yaml, 1)
    t("kw", lambda: b.lookup_transform_core(target_frame="a", source_frame="b", time=T(2)).transform.translation.x)
    t(
        "kw",
        lambda: (
            b.lookup_transform_full_core(
                target_frame="a", target_time=T(2), source_frame="c", source_time=T(3), fixed_frame="b"
            ).transform.translation.x
        ),
    )
    t("kw", lambda: b.can_transform_core(target_frame="a", source_frame="b", time=T(2)))
    w(lambda: b.get_latest_common_time(source_frame="b", target_frame="a"))
    t("clear", b.clear)
    t("string", b.all_frames_as_string)
rospy.init_node("tf2_names", anonymous=True)
b = tf2_ros.Buffer(debug=False)
l = tf2_ros.TransformListener(b)
t("cb", l.callback, TFMessage([tr("p", "q", 1, 1), tr("p", "r", 1, 2)]))
t("static", l.static_callback, TFMessage([tr("p", "s", 0, 3)]))
m = TFMessage([tr("p", "u", 1, 1)])
m._connection_header = {"callerid": "/who"}
t("cb", l.callback, m)
t("static", l.static_callback, m)
t("frames", lambda: sorted(b.all_frames_as_string().split("\n")))
t("reset", l.check_for_reset)
t("frames", lambda: sorted(b.all_frames_as_string().split("\n")))
w(l.callback, None)
w(l.callback, TFMessage([TransformStamped()]))
l.last_update = rospy.Time.now() + rospy.Duration(100)
t("reset", l.check_for_reset)
t("frames", b.all_frames_as_string)
c = tf2_ros.BufferClient("nobody_there", check_frequency=50.0, timeout_padding=rospy.Duration(0.1))
t("server", c.wait_for_server, rospy.Duration(0.05))
