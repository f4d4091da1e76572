"""Connections and servers that a program makes itself, on real sockets; requests that go through a replacement."""

import errno
import io
import os
import socket
import struct
import threading
import warnings

import rospy
import rospy.core
from rospy.exceptions import TransportInitError, TransportTerminated
from rospy.impl import tcpros_base as base
from rospy.impl import tcpros_service as service
from rospy.topics import Poller
from std_msgs.msg import Header, String
from std_srvs.srv import SetBool, Trigger, TriggerResponse


def t(title, call):
    try:
        print(title, call())
    except Exception as error:
        print(title, type(error).__name__, error)


def frame(text):
    buffer = io.BytesIO()
    rospy.msg.serialize_message(buffer, 1, String(text))
    return buffer.getvalue()


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

# Poller
one, other = socket.socketpair()
poller = Poller()
poller.add_fd(one.fileno())
print(list(poller.error_iter()), type(poller.poller).__name__)
other.close()
print(list(poller.error_epoll_iter()) == [one.fileno()])
poller.remove_fd(one.fileno())
print(list(poller.error_iter()), list(poller.noop_iter()), poller.noop(1))
poller.add_epoll(one.fileno())
poller.remove_epoll(one.fileno())
one.close()

# recv_buff, set_socket, receive_once, receive_loop
one, other = socket.socketpair()
buffer = io.BytesIO()
other.send(b"abcdef")
print(base.recv_buff(one, buffer, 4), base.recv_buff(one, buffer, 4), buffer.getvalue())
one.setblocking(False)
print(base.recv_buff(one, buffer, 4), base.EAGAIN == errno.EAGAIN, base.EWOULDBLOCK == errno.EWOULDBLOCK)
other.close()
t("ended", lambda: base.recv_buff(one, buffer, 4))
one.close()
t("closed", lambda: base.recv_buff(one, buffer, 4))

one, other = socket.socketpair()
transport = base.TCPROSTransport(base.TCPROSTransportProtocol("/a", String, 10), "/a", {"type": "x"})
t("without", transport.receive_once)
transport.set_socket(one, "the end")
t("again", lambda: transport.set_socket(one, "the end"))
print(transport.endpoint_id, transport.fileno() == one.fileno())
other.sendall(frame("a") + frame("b" * 100000) + frame("c") + frame("d")[:5])
got = []
while len(got) < 3:
    got += transport.receive_once()
print([each.data[:3] for each in got], {tuple(each._connection_header.items()) for each in got})
print(transport.stat_num_msg, transport.read_buff.getvalue() == frame("d")[:5] or "not all yet")
transport.send_message(Header(frame_id="x"), 7)
print(other.recv(100))
loop = []
other.sendall(frame("d")[5:] + frame("e"))
other.shutdown(socket.SHUT_WR)
transport.receive_loop(lambda messages, link: loop.extend((each.data, link is transport) for each in messages))
print(loop, transport.done, transport.socket)
other.close()

# read_messages
buffer, queue = io.BytesIO(), []
buffer.write(frame("x") + frame("y") + b"\x01")
base.TCPROSTransportProtocol("/a", String).read_messages(buffer, queue, None)
print([each.data for each in queue], buffer.tell(), base.TCPROSTransportProtocol("/a", String).get_header_fields())
client = service.TCPROSServiceClient("/s", Trigger)
for data in (b"\x01" + struct.pack("<I", 5) + b"\x01\x00\x00\x00\x00", b"\x00" + struct.pack("<I", 3) + b"bad"):
    buffer, queue = io.BytesIO(), []
    buffer.write(data)
    t("response", lambda: client.read_messages(buffer, queue, None))
    print([each.success for each in queue], buffer.tell())
one, other = socket.socketpair()
buffer = io.BytesIO()
buffer.write(b"\x00" + struct.pack("<I", 300)[:2])
other.sendall(struct.pack("<I", 300)[2:] + b"z" * 300)
t("long", lambda: client.read_messages(buffer, [], one))
one.close()
other.close()
provider = service.TCPService("/s", Trigger)
print(provider.get_header_fields(), provider.recv_data_class is Trigger._request_class, provider.buff_size)

# Servers
seen = threading.Event()
taken = []


def take(sock, address):
    taken.append((sock.recv(10), address[0]))
    sock.close()
    seen.set()


server = base.TCPServer(take)
server.start()
print(server.get_full_addr() == (rospy.core.rosgraph.network.get_host_name(), server.port), server.is_shutdown)
with socket.create_connection(("127.0.0.1", server.port), 10) as sock:
    sock.sendall(b"hello")
    print(seen.wait(10), taken)
server.shutdown()
print(server.is_shutdown)

server = base.TCPROSServer()
print(server.get_address())
print(server.start_server(), server.get_address()[1] > 0)
server.topic_connection_handler = lambda sock, address, header: "no topics"
server.service_connection_handler = lambda sock, address, header: "no services"
for fields in ({"topic": "/a"}, {"service": "/a"}, {"x": "y"}):
    with socket.create_connection(("127.0.0.1", server.get_address()[1]), 10) as sock:
        rospy.core.rosgraph.network.write_ros_handshake_header(sock, fields)
        t("refused", lambda: rospy.core.rosgraph.network.read_ros_handshake_header(sock, io.BytesIO(), 100))
taken = []
server.topic_connection_handler = lambda sock, address, header: (taken.append(header), sock.sendall(b"ok"), None)[2]
with socket.create_connection(("127.0.0.1", server.get_address()[1]), 10) as sock:
    rospy.core.rosgraph.network.write_ros_handshake_header(sock, {"topic": "/a", "b": "c"})
    print(sock.recv(2), taken)
server.shutdown("end")

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
host, port = base.get_tcpros_server_address()
print(port > 0)
for name in ("own", "refused", "plain", "raw"):
    provided = rospy.Service(name, Trigger, lambda request: (False, "handler"))
    t(name, lambda: str(rospy.ServiceProxy(name, Trigger)()).split("\n"))
flag = rospy.Service("flag", SetBool, lambda request: (request.data, "set"))
print(rospy.ServiceProxy("flag", SetBool)(True).success, through)
for fields in (
    {},
    {"service": "/no", "md5sum": "*", "callerid": "/x"},
    {"service": "/flag", "md5sum": "1", "callerid": "/x"},
):
    t("why", lambda: service.service_connection_handler(None, ("127.0.0.1", 1), dict(fields)))
print(service.logger.name, base.logger.name, base.python3)
