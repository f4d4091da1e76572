"""rospy's services and their callers: the same program on stock's modules and on ours, and one on each side
(P18-P21)."""

from __future__ import annotations

import itertools
import signal

import pytest
from faces import FACES, same, start
from harness import Master
from rospy_programs import TOOLS

HEAD = "import rospy\n" + TOOLS

MASTERS = ("ours",)
PAIRS = list(itertools.product(FACES, repeat=2))

HANDLER = """
from topic_tools.srv import MuxSelect, MuxSelectRequest, MuxSelectResponse
def answer(request):
    case = int(request.topic)
    if case == 1:
        raise rospy.ServiceException("own text")
    if case == 2:
        raise ValueError("f\\u00fcnf\\nlines")
    if case == 3:
        return MuxSelectResponse("whole")
    return [None, ["list"], ("tuple",), {"prev_topic": "dict"}, "text", 8, ["1", "2"], {"s": 1}, [9], True, [], {}, "",
            ("a", "b")][case - 4]
"""

SERVICE = """
rospy.init_node("services")
logging.getLogger("rosout").setLevel(logging.CRITICAL)
service = rospy.Service("mux", MuxSelect, answer)
proxy = rospy.ServiceProxy("mux", MuxSelect)
proxy.wait_for_service(20)
for case in range(1, 18):
    try:
        print(case, repr(proxy(str(case)).prev_topic))
    except rospy.ServiceException as error:
        text = str(error)
        print(case, text.split(" must be of type")[0])
t("request", lambda: (proxy(topic="3").prev_topic, proxy.call("3").prev_topic, proxy(MuxSelectRequest("3")).prev_topic))
t("wrong", lambda: proxy("4", b=1))
t("wrong", lambda: proxy("x", 1))
t("wrong", lambda: proxy(String("4")))
t("wrong", lambda: proxy(c=4))
t("attributes", lambda: (service.resolved_name, service.service_class is MuxSelect, service.uri[:9], service.done))
t("attributes", lambda: (proxy.resolved_name, proxy.request_class is MuxSelectRequest, proxy.persistent))
t("twice", lambda: rospy.Service("mux", MuxSelect, answer))
t("class", lambda: (isinstance(service, rospy.service._Service), rospy.service.ServiceManager.__name__))
manager = rospy.impl.registration.get_service_manager() if hasattr(rospy.impl, "registration") else None
none = rospy.Service("none", Empty, lambda request: None)
t("none", lambda: rospy.ServiceProxy("none", Empty)())
none.shutdown()
t("gone", lambda: rospy.ServiceProxy("none", Empty)())
again = rospy.Service("none", Empty, lambda request: EmptyResponse())
t("again", lambda: rospy.ServiceProxy("none", Empty)())
seen = []
handled = rospy.Service("handled", Empty, lambda request: 1 / 0, error_handler=lambda *args: seen.append(args))
t("handled", lambda: rospy.ServiceProxy("handled", Empty)())
print([type(each).__name__ for each in seen[0]], seen[0][1])
headers = []
told = rospy.Service("told", Empty, lambda request: headers.append(request._connection_header) or [])
rospy.ServiceProxy("told", Empty, headers={"cookie": "yes"})()
print(headers[0]["cookie"], headers[0]["callerid"], headers[0]["service"])
all_five = threading.Barrier(5)
slow = rospy.Service("slow", SetBool, lambda request: (all_five.wait(20), (True, "slow"))[1])
calls = [threading.Thread(target=lambda: rospy.ServiceProxy("slow", SetBool)(True)) for _ in range(5)]
for call in calls:
    call.start()
for call in calls:
    call.join()
print("at once", not all_five.broken)
kept = rospy.ServiceProxy("mux", MuxSelect, persistent=True)
print([kept("3").prev_topic for _ in range(3)])
kept.close()
t("wait", lambda: rospy.wait_for_service("nowhere", 0.1))
t("wait", lambda: rospy.wait_for_service("~nowhere", 0.1))
t("wait", lambda: rospy.wait_for_service("mux"))
"""

SERVE = """
rospy.init_node("serve")
service = rospy.Service("mux", MuxSelect, answer)
class Ends:
    pass
def end(request):
    threading.Timer(0.05, service.shutdown, ("asked for",)).start()
    return []
rospy.Service("end", Empty, end)
print("ready", flush=True)
service.spin()
print("spun", service.done, rospy.is_shutdown(), flush=True)
"""
CALL = """
rospy.wait_for_service("mux", 30)  # no node is needed
print(rospy.ServiceProxy("mux", MuxSelect)("3").prev_topic)
rospy.init_node("call")
proxy = rospy.ServiceProxy("mux", MuxSelect, persistent=True)
print([proxy(case).prev_topic for case in "3568"])
for case in "1214":
    t("failed", lambda: rospy.ServiceProxy("mux", MuxSelect)(case))
proxy.close()
try:
    rospy.ServiceProxy("end", Empty)()
except rospy.ServiceException:
    print("ended before its answer was sent")
def gone():
    try:
        rospy.ServiceProxy("mux", MuxSelect)("3")
    except rospy.ServiceException as error:
        return "unavailable" in str(error)
until(gone)
print("gone")
"""

OWN_CONNECTION = """
from rospy.impl.tcpros_base import DEFAULT_BUFF_SIZE, TCPROSTransport
from rospy.impl.tcpros_service import TCPROSServiceClient
rospy.init_node("own_connection")
logging.getLogger("rosout").setLevel(logging.CRITICAL)
service = rospy.Service("mux", MuxSelect, answer)
uri = rospy.get_master().lookupService(rospy.resolve_name("mux"))[2]
def call(case, cls=MuxSelect):
    transport = TCPROSTransport(TCPROSServiceClient("/mux", cls, headers={}), "/mux")
    transport.buff_size = DEFAULT_BUFF_SIZE
    transport.connect(*rospy.core.parse_rosrpc_uri(uri), uri, timeout=5)
    transport.send_message(rospy.msg.args_kwds_to_message(cls._request_class, (case,), {}), 0)
    try:
        response = transport.receive_once()[0]
        print(response._connection_header["callerid"])
        return response.prev_topic
    finally:
        transport.close()
t("call", lambda: call("3"))
t("call", lambda: call("1"))
try:
    call(True, SetBool)
except rospy.TransportInitError as error:
    print("md5sums do not match" in str(error))
"""

HEADERS = """
import sys
rospy.init_node(sys.argv[1])
def show(what, header):
    more = ["request_type", "response_type"] if what == "response" else ["type"]
    more += ["persistent"] if header.get("persistent") == "0" else []
    print("HEADER", what, sorted(field for field in header.items() if field[0] not in more), flush=True)
if sys.argv[1] == "serve":
    service = rospy.Service("told", SetBool, lambda request: (show("request", request._connection_header), [True, ""])[1])
    print("ready", flush=True)
    rospy.spin()
    sys.exit()
for kept in (False, True):
    proxy = rospy.ServiceProxy("told", SetBool, persistent=kept, headers={"cookies": "peanut butter"})
    for _ in range(2):
        show("response", proxy(True)._connection_header)
"""


def test_handlers_and_calls(launcher: Master) -> None:
    said = same(launcher, HEAD + HANDLER + SERVICE)
    assert "b'service cannot process request: own text'" in said and "at once True" in said


def test_own_connection(launcher: Master) -> None:
    assert "whole" in same(launcher, HEAD + HANDLER + OWN_CONNECTION)


@pytest.mark.parametrize(("server", "client"), PAIRS)
def test_pairs(launcher: Master, server: str, client: str) -> None:
    serve = start(server, launcher, HEAD + HANDLER + SERVE)
    serve.wait_line("ready")
    call = start(client, launcher, HEAD + HANDLER + CALL)
    call.wait_line("whole")
    call.wait_line(r"\['whole', 'list', 'tuple', 'text'\]")
    call.wait_line("failed !! .*b'service cannot process request: own text'")
    call.wait_line(r"failed !! .*b'error processing request: f\\xc3\\xbcnf\\nlines'")
    call.wait_line("gone")
    assert call.wait() == 0
    serve.wait_line("spun True False")
    assert serve.wait() == 0


def test_headers_of_requests_and_responses(launcher: Master) -> None:
    """The classic tutorial prints them. Ours have those fields, too, that roscpp's have."""
    told = []
    for server, client in PAIRS:
        serve = start(server, launcher, HEAD + HEADERS, "serve")
        serve.wait_line("ready")
        call = start(client, launcher, HEAD + HEADERS, "call")
        assert call.wait() == 0
        serve.signal(signal.SIGINT)
        assert serve.wait() == 0, serve.transcript()
        told.append([line for each in (serve, call) for line in each.lines if line.startswith("HEADER")])
    assert len(told[0]) == 8
    assert told == [told[0]] * 4
