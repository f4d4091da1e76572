"""rospy by pyros1, in programs as users write them."""

from __future__ import annotations

from programs import run, start

TALKER = """
import rospy
from std_msgs.msg import Float64
rospy.init_node("talker")
publisher = rospy.Publisher("topic1", Float64, queue_size=10)
rate = rospy.Rate(100)
try:
    while not rospy.is_shutdown():
        publisher.publish(2.5)
        rate.sleep()
except rospy.ROSInterruptException:
    pass
"""
LISTENER = """
import rospy
from std_msgs.msg import Float64
def hear(message):
    rospy.loginfo("received %s on %s", message.data, message._connection_header["topic"])
    rospy.signal_shutdown("heard it")
rospy.init_node("listener", anonymous=True)
rospy.Subscriber("topic1", Float64, hear)
rospy.spin()
"""


def test_talker_and_listener(environ: dict[str, str]) -> None:
    talker = start(TALKER, environ)
    try:
        said = run(LISTENER, environ)
    finally:
        talker.terminate()
        out, _ = talker.communicate(timeout=10)
    assert "received 2.5 on /topic1" in said
    assert not out


def test_at_debug_level_a_program_says_which_rospy_runs(environ: dict[str, str]) -> None:
    program = "import rospy; rospy.init_node('asker', log_level=rospy.{}); print(rospy.__path__[0])"
    said = run(program.format("DEBUG"), environ).splitlines()
    assert said.pop(-1) in said[0] and "init_node, name[/asker], pid[" in said[0]
    assert "init_node" not in run(program.format("INFO"), environ)


def test_a_wrong_address_of_the_master_is_an_error_of_init_node(environ: dict[str, str]) -> None:
    program = "import rospy\ntry: rospy.init_node('asker')\nexcept rospy.ROSInitException as error: print(error)"
    assert "not a URI of the form http://host:port/: 'nonsense'" in run(
        program, {**environ, "ROS_MASTER_URI": "nonsense"}
    )


def test_a_message_for_the_first_of_several_fields_is_not_enough(environ: dict[str, str]) -> None:
    program = "from rospy.msg import args_kwds_to_message\nfrom geometry_msgs.msg import Twist, Vector3\n"
    program += "try: args_kwds_to_message(Twist, (Vector3(),), {})\nexcept TypeError as error: print(error)"
    assert "Invalid number of arguments, args should be ['linear', 'angular']" in run(program, environ)


def test_before_a_node_warnings_are_seen_as_those_of_pythons_loggers(environ: dict[str, str]) -> None:
    text = 'import rospy\nrospy.loginfo("information")\nrospy.logwarn("a %s", "warning")\nrospy.logerr("an error")\n'
    assert run(text, environ).splitlines() == ["a warning", "an error"]
