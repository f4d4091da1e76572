"""Binary parameters."""

import re
import rosgraph
import rosparam
import rospy
from xmlrpc.client import Binary


def t(title, call, *a):
    try:
        x = repr(call(*a))
    except Exception as e:
        x = f"{type(e).__name__}: {e}"
    print(title, re.sub(" at 0x[0-9a-f]+", "", x), flush=True)


rospy.init_node("x", anonymous=True)
m = rosgraph.Master("/x")
for setter in (
    lambda n, v: rospy.set_param(n, v),
    lambda n, v: m.setParam(n, v),
    lambda n, v: rosparam.set_param_raw(n, v),
    lambda n, v: rosparam.upload_params("/", {n.strip("/"): v}),
):
    for v in (Binary(b"hello"), b"bytes", bytearray(b"arr"), {"a": Binary(b"in")}, [Binary(b"x")]):
        t("set", setter, "/blobby", v)
        for get in (rospy.get_param, m.getParam, rosparam.get_param):
            t("get", lambda: (lambda r: (type(r).__name__, r.data if isinstance(r, Binary) else r))(get("/blobby")))
        m.setParam("/blobby", 0)
t("text", rosparam.set_param, "/blobby", "!!binary aGVsbG8=")
t("get", lambda: rosparam.get_param("/blobby").data)


rospy.set_param("/bl", Binary(b"q"))
m = rospy.get_master()


def f(x):
    return x.data if isinstance(x, Binary) else x


print(
    f(m["/bl"]),
    f(m.getParam("/bl")[2]),
    f(rospy.get_param_cached("/bl")),
    f(rospy.get_param_cached("/bl")),
    type(m.getParam("/bl")[2]).__name__,
)
rospy.set_param("/bl2/x", Binary(b"q"))
print({k: f(v) for k, v in rospy.get_param("/bl2").items()}, type(m["/bl2"]["x"]).__name__)
