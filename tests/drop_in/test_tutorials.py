"""Tutorials of rospy whose types stock's Python packages of Debian lack: rospy_tutorials as it is shipped."""

from __future__ import annotations

import pytest
from programs import run, start

SERVER = """
from __future__ import print_function
from rospy_tutorials.srv import AddTwoInts, AddTwoIntsResponse
import rospy

def handle_add_two_ints(req):
    print("Returning [%s + %s = %s]" % (req.a, req.b, req.a + req.b), flush=True)
    return AddTwoIntsResponse(req.a + req.b)

rospy.init_node("add_two_ints_server")
rospy.Service("add_two_ints", AddTwoInts, handle_add_two_ints)
rospy.spin()
"""
CLIENT = """
import sys
import rospy
from rospy_tutorials.srv import *
rospy.wait_for_service("add_two_ints")
add_two_ints = rospy.ServiceProxy("add_two_ints", AddTwoInts)
x, y = (int(word) for word in sys.argv[1:])
print(add_two_ints(x, y).sum, add_two_ints(AddTwoIntsRequest(x, y)).sum, add_two_ints(b=y, a=x).sum)
"""


def test_add_two_ints(environ: dict[str, str]) -> None:
    server = start(SERVER, environ)
    try:
        assert run(CLIENT, environ, "3", "-5") == "-2 -2 -2\n"
    finally:
        server.terminate()
        out, _ = server.communicate(timeout=10)
    assert out == "Returning [3 + -5 = -2]\n" * 3


FLOATS = """
import numpy, rospy
from rospy.numpy_msg import numpy_msg
from rospy_tutorials.msg import Floats, HeaderString
rospy.init_node("floats")
heard = []
rospy.Subscriber("floats", numpy_msg(Floats), heard.append)
rospy.Subscriber("header", HeaderString, heard.append)
floats = rospy.Publisher("floats", numpy_msg(Floats), queue_size=1, latch=True)
header = rospy.Publisher("header", HeaderString, queue_size=1, latch=True)
floats.publish(numpy.array([1.0, 2.1, 3.5], dtype=numpy.float32))
while len(heard) < 1:
    rospy.sleep(0.01)
header.publish(None, "test")
while len(heard) < 2:
    rospy.sleep(0.01)
print(heard[0].data.dtype, heard[0].data.sum(), heard[1].data, heard[1].header.seq)
"""


@pytest.mark.slow
def test_numpy_and_headers(environ: dict[str, str]) -> None:
    assert run(FLOATS, environ) == "float32 6.6 test 1\n"
