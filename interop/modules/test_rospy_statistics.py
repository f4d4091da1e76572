"""rospy's /statistics: the same program on stock's modules and on ours (P41)."""

from __future__ import annotations

from faces import same
from harness import Master
from rospy_programs import TOOLS

MASTERS = ("ours",)
PROGRAM = """
from rosgraph_msgs.msg import TopicStatistics
rospy.set_param("/enable_statistics", True)
rospy.init_node("counts")
got = []
s = rospy.Subscriber("/statistics", TopicStatistics, got.append)
a = rospy.Publisher("stamped", PointStamped, queue_size=100)
b = rospy.Publisher("plain", Float64, queue_size=100)
subscribers = [rospy.Subscriber("stamped", PointStamped, lambda m: 0), rospy.Subscriber("plain", Float64, lambda m: 0)]
rospy.delete_param("/enable_statistics")
until(lambda: a.get_num_connections() and b.get_num_connections())
def both():
    a.publish(PointStamped(header=Header(stamp=rospy.Time.now())))
    b.publish(1)
    time.sleep(0.02)
    return {m.topic for m in got if m.delivered_msgs > 10} == {"/stamped", "/plain"}
until(both)
for topic in ("/plain", "/stamped"):
    m = next(m for m in got if m.topic == topic and m.delivered_msgs > 10)
    print(m.topic, m.node_pub, m.node_sub, m.traffic / m.delivered_msgs, m.dropped_msgs, m.delivered_msgs > 10)
    seconds = (m.window_stop - m.window_start).to_sec()
    print(seconds > 0.9, m.period_mean.to_sec() > 0.015, m.period_max >= m.period_mean, m.stamp_age_max.is_zero())
"""


def test_statistics(launcher: Master) -> None:
    assert "/stamped /counts /counts 44.0 0 True" in same(launcher, "import rospy\n" + TOOLS + PROGRAM)
