"""Connections of programs, and empty messages as YAML; stock's are in interop/modules."""

from __future__ import annotations

from programs import run

CONNECTION = """
import io, socket, struct
from rospy.impl.answering import Exchange
from rospy.impl.tcpros_base import TCPROSTransport, TCPROSTransportProtocol, recv_buff
from std_msgs.msg import String
from std_srvs.srv import Trigger, TriggerResponse

one, other = socket.socketpair()
transport = TCPROSTransport(TCPROSTransportProtocol("/a", String), "/a")
transport.set_socket(one, "/x")
text = io.BytesIO()
String("hi").serialize(text)
other.sendall(2 * (struct.pack("<I", len(text.getvalue())) + text.getvalue()))
other.shutdown(socket.SHUT_WR)
got = []
transport.receive_loop(lambda messages, link: got.extend(each.data for each in messages))
print(got, transport.done)
other.close()

for write in (
    lambda exchange: exchange.send_message(TriggerResponse(True, "a"), 1),
    lambda exchange: exchange.write_data(struct.pack("<BI", 0, 3) + b"bad"),
    lambda exchange: None,
):
    exchange = Exchange("/s", Trigger._request_class())
    write(exchange)
    try:
        print(exchange.answer(TriggerResponse).message)
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
        "['hi', 'hi'] True",
        "a",
        "ServiceRefusal bad",
        "ServiceRefusal the service has sent no answer",
    ]


def test_a_name_that_no_program_uses_says_what_to_use() -> None:
    assert run(PROTOTYPE, {}).strip() == "pyros1 has no rosmsg.rosmsg_cmd_prototype: see the command `rosmsg-proto`"
