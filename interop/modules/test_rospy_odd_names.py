"""Names that break the rules work in rospy, with a warning: the same program on stock's modules and on ours."""

from __future__ import annotations

from faces import same
from harness import Master
from rospy_programs import TOOLS

MASTERS = ("ours",)
PROGRAM = """
warnings.simplefilter("always")
said = []
warnings.showwarning = lambda message, *rest: said.append(str(message))
rospy.init_node("my-node")
print(rospy.get_name())
for name in ("cmd-vel", "2d", "a.b"):
    p = rospy.Publisher(name, String, queue_size=1)
    got = []
    s = rospy.Subscriber(name, String, got.append)
    until(lambda: p.get_num_connections())
    p.publish("x")
    until(lambda: got)
    e = rospy.Service("s" + name, Empty, lambda request: [])
    t("names", lambda: (p.resolved_name, e.resolved_name, rospy.ServiceProxy("s" + name, Empty)()))
    t("param", lambda: (rospy.set_param("p" + name, 1), rospy.get_param("p" + name)))
print([text for text in said if "SyntaxWarning" not in text and "Publisher" not in text][:2])
"""


def test_odd_names(launcher: Master) -> None:
    assert "/cmd-vel" in same(launcher, "import rospy\n" + TOOLS + PROGRAM)


def test_a_node_whose_name_has_a_blank(launcher: Master) -> None:
    """The master refuses its services; topics and parameters work."""
    program = """
rospy.init_node("My Node")
p = rospy.Publisher("t", String, queue_size=1)
got = []
rospy.Subscriber("t", String, got.append)
until(lambda: p.get_num_connections())
p.publish("x")
until(lambda: got)
print(rospy.get_name(), got)
"""
    assert "/My Node" in same(launcher, "import rospy\n" + TOOLS + program)
