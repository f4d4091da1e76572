"""The state before the node, and requests that go through a replacement."""

import os
import struct
import warnings

import rospy
import rospy.core
from rospy.impl import tcpros_service as service
from std_srvs.srv import SetBool, Trigger, TriggerResponse


def t(title, call):
    try:
        print(title, call())
    except Exception as error:
        print(title, type(error).__name__, error)


# Before the node
print(rospy.core.is_initialized(), rospy.core.get_node_uri())
rospy.core.set_initialized(True)
rospy.core.set_node_uri("http://a:1/")
print(rospy.core.is_initialized(), rospy.core.get_node_uri())
rospy.core.set_initialized(False)
rospy.core.set_node_uri(None)
t("no name", lambda: rospy.core.configure_logging("/"))
t("log", lambda: rospy.core.configure_logging("/a/b"))
print(os.path.exists(os.environ["ROS_LOG_DIR"]))


@rospy.core.deprecated
def old(value):
    """Return it."""
    return value


with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    print(old(3), old.__name__, old.__doc__, [str(each.message) for each in caught])

# Services: requests go through what replaces _handle_request
original = service.ServiceImpl._handle_request
through = []


def handle(self, transport, request):
    through.append((self.resolved_name, request._connection_header["service"], transport.name))
    if self.resolved_name == "/own":
        transport.write_buff.write(struct.pack("<B", 1))
        transport.send_message(TriggerResponse(True, "own"), 1)
    elif self.resolved_name == "/refused":
        self._write_service_error(transport, "refused by the program")
    elif self.resolved_name == "/raw":
        transport.write_data(b"\x01" + struct.pack("<I", 6) + b"\x01\x01\x00\x00\x00r")
    else:
        original(self, transport, request)


service.ServiceImpl._handle_request = handle
rospy.init_node("tcpros_program")
for name in ("own", "refused", "plain", "raw"):
    provided = rospy.Service(name, Trigger, lambda request: (False, "handler"))
    t(name, lambda: str(rospy.ServiceProxy(name, Trigger)()).split("\n"))
flag = rospy.Service("flag", SetBool, lambda request: (request.data, "set"))
print(rospy.ServiceProxy("flag", SetBool)(True).success, through)
print(service.logger.name)
