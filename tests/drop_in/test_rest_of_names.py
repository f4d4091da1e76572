"""Connections of programs, and names that are left out; stock's are in interop/modules."""

from __future__ import annotations

from programs import run

CONNECTION = """
import io, socket, struct, threading
from pyros1.wire.header import encode_header
from rospy.impl.request_transport import RequestTransport
from rospy.impl.tcpros_base import TCPROSTransport
from rospy.impl.tcpros_service import TCPROSServiceClient
from std_srvs.srv import Trigger, TriggerResponse

server = socket.create_server(("127.0.0.1", 0))

def provide():
    sock = server.accept()[0]
    sock.recv(1000)
    header = encode_header({"md5sum": Trigger._md5sum, "type": "std_srvs/Trigger", "callerid": "/provider"})
    text = io.BytesIO()
    TriggerResponse(True, 200 * "x").serialize(text)
    response = bytes([1]) + struct.pack("<I", len(text.getvalue())) + text.getvalue()
    sock.sendall(header + response)  # at once: the response comes with the header
    sock.sendall(response[:50])
    sock.sendall(response[50:] + bytes([0]) + struct.pack("<I", 3) + b"bad" + bytes([1, 255, 255, 255, 255]))
    sock.close()

threading.Thread(target=provide).start()
transport = TCPROSTransport(TCPROSServiceClient("/s", Trigger), "/s")
transport.connect("127.0.0.1", server.getsockname()[1], "rosrpc://provider", timeout=10)
for _ in range(4):
    try:
        response = transport.receive_once()[0]
        print(response.message == 200 * "x", response._connection_header["callerid"])
    except Exception as error:
        print(type(error).__name__, error)
transport.close()
server.close()
print(transport.done, transport.callerid_pub)

for write in (
    lambda exchange: exchange.send_message(TriggerResponse(True, "a"), 1),
    lambda exchange: exchange.write_data(struct.pack("<BI", 0, 3) + b"bad"),
    lambda exchange: None,
):
    exchange = RequestTransport("/s", Trigger._request_class())
    write(exchange)
    try:
        print(exchange.get_response(TriggerResponse).message)
    except Exception as error:
        print(type(error).__name__, error)
"""
PROTOTYPE = """
import rosmsg
try:
    rosmsg.rosmsg_cmd_prototype
except AttributeError as error:
    print(error)
"""


def test_a_connection_of_a_program_and_the_answers_to_a_request() -> None:
    assert run(CONNECTION, {}).splitlines() == [
        "True /provider",
        "True /provider",
        "ServiceException service [/s] responded with an error: b'bad'",
        "TransportException a message of 4294967295 bytes is too large",
        "True /provider",
        "a",
        "ServiceRefusal bad",
        "ServiceRefusal the service has sent no response",
    ]


def test_a_name_that_no_program_uses_says_what_to_use() -> None:
    assert run(PROTOTYPE, {}).strip() == "pyros1 has no rosmsg.rosmsg_cmd_prototype: see the command `rosmsg-proto`"
