"""Parts of the modules that stock's own versions cannot do on today's Python, or that need a moving clock."""

from __future__ import annotations

from programs import run

GRAPH = """
import rosgraph, rosgraph.impl.graph as graph, socket, sys
with socket.socket() as listener:
    listener.bind(("127.0.0.1", 0))
    dead = f"http://127.0.0.1:{listener.getsockname()[1]}/"
rosgraph.Master("/parts/dead").registerPublisher("/parts/topic", "std_msgs/String", dead)
found = graph.Graph("/parts", "/parts")
assert found.update()
assert {name: bad.type for name, bad in found.bad_nodes.items()} == {"/parts/dead": graph.BadNode.DEAD}
assert not found.bad_update()  # it is still dead
assert sorted(found.bad_nodes) == ["/parts/dead"]
import rospy
sys.argv.append("__ns:=/parts")
rospy.init_node("dead")
rospy.Publisher("/parts/topic", rospy.AnyMsg, queue_size=1)
found.node_uri_map.clear()
assert found.bad_update()
assert not found.bad_nodes
"""

ADDRESSES = """
import roslib.network as old, rosgraph.network as new
assert old.get_local_addresses() == new.get_local_addresses()
assert old.get_local_address() in old.get_local_addresses()
assert old.is_local_address("localhost") and old.is_local_address(old.get_local_address())
assert not old.is_local_address("192.0.2.200")
"""

CLOCK = """
import threading, rospy
from rosgraph_msgs.msg import Clock
rospy.set_param("/use_sim_time", True)
rospy.init_node("ticking")
condition = rospy.rostime.get_rostime_cond()
publisher = rospy.Publisher("/clock", Clock, queue_size=1)
seen = []
def look():
    with condition:
        ready.set()
        while not seen:
            assert condition.wait(15)
            seen.append(rospy.get_time())
ready = threading.Event()
thread = threading.Thread(target=look)
thread.start()
assert ready.wait(15)
while thread.is_alive():
    publisher.publish(rospy.Time(5))
    thread.join(0.02)
assert seen == [5.0], seen
ended = []
def wait():
    with condition:
        ready.set()
        ended.append(condition.wait(15))
ready.clear()
thread = threading.Thread(target=wait)
thread.start()
assert ready.wait(15)
with condition:
    pass  # it waits
rospy.signal_shutdown("end")
thread.join(15)
assert ended == [True]
"""

COPIES = """
import threading, rospy
import rospy.impl.paramserver as paramserver
rospy.init_node("copies")
rospy.set_param("~gain", 1)
assert rospy.get_param_cached("~gain") == 1
calls, called = [], threading.Event()
cache = paramserver.get_param_server_cache()
cache.set_notifier(lambda name, value: (calls.append((name.rstrip("/"), value)), called.set()))
import rosgraph
rosgraph.Master("/other").setParam("/copies/gain", 2)  # somebody else
assert called.wait(15)
assert calls == [("/copies/gain", 2)], calls
assert rospy.get_param_cached("~gain") == cache.get("~gain") == 2
cache.set_notifier(None)
"""


def test_bad_nodes_are_asked_again(environ: dict[str, str]) -> None:
    run(GRAPH, environ)


def test_addresses_by_the_old_name(environ: dict[str, str]) -> None:
    run(ADDRESSES, {**environ, "ROS_HOSTNAME": ""})


def test_a_condition_is_notified_of_simulated_times_and_the_end(environ: dict[str, str]) -> None:
    run(CLOCK, environ)


def test_changes_of_parameters_by_others_are_told(environ: dict[str, str]) -> None:
    run(COPIES, environ)
