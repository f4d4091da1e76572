"""rostopic, rosnode, rosservice, rosparam and rosmsg by pyros1, in programs as users write them."""

from __future__ import annotations

from pathlib import Path

import pytest
from programs import run, start

ROBOT = """
import rospy
from std_msgs.msg import Header
from std_srvs.srv import Trigger, TriggerResponse
rospy.init_node("robot")
headers = rospy.Publisher("headers", Header, queue_size=1)
rospy.Service("stop", Trigger, lambda request: TriggerResponse(True, "stopped"))
rate = rospy.Rate(100)
try:
    while not rospy.is_shutdown():
        headers.publish(Header(stamp=rospy.Time.now()))
        rate.sleep()
except rospy.ROSInterruptException:
    pass
"""

ASKING = """
import rosnode, rospy, rosservice, rostopic
rospy.init_node("asking")
rospy.wait_for_service("/stop", 20)
kind, topic, field = rostopic.get_topic_class("/headers/stamp/secs", blocking=True)
assert (kind._type, topic) == ("std_msgs/Header", "/headers")
rates, ages = rostopic.ROSTopicHz(20), rostopic.ROSTopicDelay(20)
heard = []
class Stamped:
    _has_header = True
    def __init__(self, header):
        self.header = header
def pass_on(message):
    rates.callback_hz(message)
    ages.callback_delay(Stamped(message))
    heard.append(field(message))
rospy.Subscriber("/headers", kind, pass_on)
deadline = rospy.get_time() + 30
while len(heard) < 30:
    assert rospy.get_time() < deadline
    rospy.sleep(0.02)
rate, least, most, deviation, count = rates.get_hz()
assert rate > 10 and 0 <= least <= most and count == 20, rate
assert ages.get_delay()[4] == 20
assert "/headers" in rostopic.find_by_type("std_msgs/Header")
assert "Publishers: \\n * /robot (http://" in rostopic.get_info_text("/headers")
assert rosservice.get_service_type("/stop") == "std_srvs/Trigger"
assert "/stop" in rosservice.get_service_list(node="/robot")
assert rosservice.call_service("/stop", [])[1].message == "stopped"
assert "/robot" in rosnode.get_node_names() and rosnode.rosnode_ping("/robot", max_count=1)
assert rosnode.kill_nodes(["/robot", "/not_there"]) == (["/robot"], ["/not_there"])
print("done")
"""

FILES = """
import os, sys
import rosmsg, rosparam, yaml
os.chdir(sys.argv[1])
with open("good.yaml", "w") as file:
    file.write("gain: 2.5\\nangle: !degrees 180\\nlimits: {low: -1, high: deg(90)}\\n")
    file.write("---\\n_ns: arm\\njoints: [a, b]\\n")
for values, namespace in rosparam.load_file("good.yaml", default_namespace="/robot"):
    rosparam.upload_params(namespace, values)
assert rosparam.list_params("/robot") == [
    "/robot/angle", "/robot/arm/joints", "/robot/gain", "/robot/limits/high", "/robot/limits/low"]
assert rosparam.get_param("/robot/arm") == {"joints": ["a", "b"]}
assert abs(rosparam.get_param("/robot/angle") - 3.14) < 0.01
rosparam.dump_params("out.yaml", "/robot/arm")
assert yaml.safe_load(open("out.yaml")) == {"joints": ["a", "b"]}
rosparam.delete_param("/robot")
assert rosparam.list_params("/robot") == []
from xmlrpc.client import Binary
rosparam.set_param("/blob", "!!binary aGVsbG8=")
assert rosparam.get_param("/blob") == Binary(b"hello")
assert yaml.safe_load(yaml.dump({"blob": Binary(b"hello")})) == {"blob": Binary(b"hello")}
assert rosparam.represent_xml_binary(yaml.SafeDumper(sys.stderr), Binary(b"hello")).value.strip() == "aGVsbG8="
for text in ("!degrees __import__('os')", "rad(9**9**9**9)"):
    try:
        rosparam.load_str("a: " + text, "text")
    except rosparam.RosParamException:
        continue
    raise AssertionError(text)
try:
    rosparam.load_file("not_there.yaml")
except rosparam.RosParamException as error:
    assert str(error) == "file [not_there.yaml] does not exist"
assert rosmsg.list_types("std_srvs", rosmsg.MODE_SRV)[:1] == ["std_srvs/Empty"]
assert rosmsg.get_msg_text("geometry_msgs/PointStamped").splitlines()[-1] == "  float64 z"
assert rosmsg.rosmsg_md5(rosmsg.MODE_SRV, "std_srvs/Trigger") == "937c9679a518e3a18d831e57125ea522"
try:
    rosmsg.no_name
except AttributeError as error:
    assert "pyros1 has no rosmsg.no_name" in str(error)
print("done")
"""


@pytest.mark.slow
def test_a_running_system(environ: dict[str, str]) -> None:
    robot = start(ROBOT, environ)
    try:
        assert run(ASKING, environ).endswith("done\n")
        assert robot.wait(20) == 0
    finally:
        robot.kill()
        robot.communicate(timeout=10)


def test_parameters_and_definitions(environ: dict[str, str], tmp_path: Path) -> None:
    assert run(FILES, environ, str(tmp_path)) == "done\n"


NO_MASTER = """
import rosparam, rostopic
for ask in (
    lambda: rosparam.get_param("/a"), lambda: rosparam.list_params("/"), lambda: rosparam.set_param("/a", "1"),
    lambda: rosparam.delete_param("/a"), lambda: rosparam.upload_params("/", {"a": 1}),
    lambda: rosparam.dump_params("a.yaml", "/"), lambda: rostopic.get_info_text("/a"),
):
    try:
        ask()
    except (rosparam.RosParamIOException, rostopic.ROSTopicIOException) as error:
        assert str(error) == "Unable to communicate with master!"
    else:
        raise AssertionError(ask)
"""


def test_a_master_that_does_not_answer() -> None:
    run(NO_MASTER, {"ROS_MASTER_URI": "http://127.0.0.1:1"})


EMPTY = """
import rosparam
rosparam.upload_params("/n", {"a": {}, "b": {"c": {}, "d": 1}})
assert rosparam.get_param("/n") == {"a": {}, "b": {"c": {}, "d": 1}}
rosparam.set_param("/n/a/x", "5")
rosparam.upload_params("/n", {"a": {}})
rosparam.upload_params("/", {})
assert rosparam.get_param("/n/a") == {"x": 5}
"""


def test_empty_dictionaries_are_kept(environ: dict[str, str]) -> None:
    run(EMPTY, environ)
