"""A node of stock rospy that comes to `interop/soak.py`, hears some numbers, publishes some, and goes.

Arguments: the visitor's number, and how many messages it publishes.
"""

import sys
import threading

import rospy
from std_msgs.msg import Float64
from std_srvs.srv import SetBool

HEARD = 20


def main(visitor, count):
    heard = []
    enough = threading.Event()

    def take(message):
        heard.append(message.data)
        if len(heard) >= HEARD:
            enough.set()

    rospy.init_node("soak_visitor_rospy", disable_signals=False)
    rospy.Subscriber("/soak/numbers", Float64, take)
    publisher = rospy.Publisher("/soak/visits", Float64, queue_size=None)
    rospy.wait_for_service("/soak/answer", 30)
    assert rospy.ServiceProxy("/soak/answer", SetBool)(True).success
    rospy.get_param("/soak/beat")
    assert enough.wait(30), f"too few messages: {heard}"
    assert heard == [heard[0] + step for step in range(len(heard))], f"gaps: {heard}"
    while publisher.get_num_connections() < 2 and not rospy.is_shutdown():
        rospy.sleep(0.02)
    for number in range(count):
        publisher.publish(visitor * 10000.0 + number)
    print("visited")
    sys.stdout.flush()
    sys.stdin.readline()  # stays until it is told to go, or killed


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))
