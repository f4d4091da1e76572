"""handshake: who may talk to whom (T06-T13, T23-T25, T33)."""

from __future__ import annotations

import pytest

from pyros1.ground.errors import ConnectionRefusedByPeerError, ProtocolError
from pyros1.wire import handshake as h

STRING = h.TopicType("std_msgs/String", "992c", "string data")
BOOL = h.TopicType("std_msgs/Bool", "8b94", "bool data")
ANY = h.TopicType("*", "*")
SET_BOOL = h.ServiceType("std_srvs/SetBool", "09fb", "std_srvs/SetBoolRequest", "std_srvs/SetBoolResponse")


def ask(wanted: h.TopicType, **changes: str) -> dict[str, str]:
    return {**h.make_subscriber_header("/listener", "/chatter", wanted, True), **changes}


def answer(header: dict[str, str]) -> dict[str, str]:
    return h.make_publisher_response(header, "/talker", "/chatter", STRING, True, {"extra": "x"})


def test_t06_t07_both_headers() -> None:
    header = ask(STRING)
    assert header["tcp_nodelay"] == "1" and header["callerid"] == "/listener"
    reply = answer(header)
    assert reply["latching"] == "1" and reply["message_definition"] == "string data" and reply["extra"] == "x"
    h.check_publisher_response(reply, "/chatter", STRING, "http://p/")


def test_t09_wildcard_gets_the_real_type() -> None:
    reply = answer(ask(ANY))
    assert (reply["type"], reply["md5sum"]) == ("std_msgs/String", "992c")
    h.check_publisher_response(reply, "/chatter", ANY, "http://p/")


def test_t10_other_type_name_with_equal_md5_is_accepted() -> None:
    assert answer(ask(STRING, type="other_msgs/Text"))["type"] == "std_msgs/String"


def test_t11_mismatch_names_both_sides() -> None:
    with pytest.raises(h.Refusal, match=r"\[std_msgs/Bool\] vs. \[std_msgs/String\]"):
        answer(ask(BOOL))
    with pytest.raises(h.Refusal, match=r"/listener.*std_msgs/String/0000.*std_msgs/String/992c"):
        answer(ask(STRING, md5sum="0000"))


@pytest.mark.parametrize("field", ["topic", "md5sum", "callerid"])
def test_t12_missing_field(field: str) -> None:
    with pytest.raises(h.Refusal, match=f"Missing required '{field}' field"):
        answer(ask(STRING, **{field: ""}))


def test_t08_error_answer_is_a_refusal() -> None:
    with pytest.raises(ConnectionRefusedByPeerError, match="because"):
        h.check_publisher_response({"error": "because"}, "/chatter", STRING, "http://p/")


def test_t15_the_md5_in_the_answer_is_the_publishers_affair() -> None:
    reply = answer(ask(ANY))
    odd = h.check_publisher_response(reply, "/chatter", BOOL, "http://p/")
    assert "http://p/ sends /chatter as std_msgs/String" in odd and "wants std_msgs/Bool" in odd
    for fine in (reply, {**reply, "md5sum": "*"}):
        assert h.check_publisher_response(fine, "/chatter", STRING, "http://p/") == ""
    assert "wants" in h.check_publisher_response({"type": "", "md5sum": ""}, "/chatter", STRING, "http://p/")
    with pytest.raises(ProtocolError, match="'md5sum'"):
        h.check_publisher_response({"type": "x"}, "/chatter", BOOL, "http://p/")


def test_whoever_sends_back_our_header_is_no_node() -> None:
    sent = ask(STRING)
    with pytest.raises(ProtocolError, match="publisher http://p/ of /chatter only sends back what it receives"):
        h.check_publisher_response(dict(sent), "/chatter", STRING, "http://p/", sent)
    h.check_publisher_response(answer(sent), "/chatter", STRING, "http://p/", sent)
    sent = h.make_service_client_header("/me", "/flip", SET_BOOL, True)
    with pytest.raises(ProtocolError, match="service /flip only sends back what it receives"):
        h.check_service_response(dict(sent), "/flip", SET_BOOL, sent)


def test_t23_t24_service_headers() -> None:
    header = h.make_service_client_header("/me", "/flip", SET_BOOL, True)
    assert header["persistent"] == "1"
    reply = h.make_service_response(header, "/server", "/flip", SET_BOOL)
    assert reply["request_type"] == "std_srvs/SetBoolRequest"
    assert h.check_service_response(reply, "/flip", SET_BOOL) == ""
    assert h.check_service_response({"md5sum": "09fb"}, "/flip", SET_BOOL) == ""


def test_t25_probe_with_wildcard_is_answered() -> None:
    header = {"callerid": "/x", "service": "/flip", "md5sum": "*", "probe": "1"}
    assert h.make_service_response(header, "/server", "/flip", SET_BOOL)["type"] == "std_srvs/SetBool"


def test_t33_service_md5_mismatch() -> None:
    header = {"callerid": "/x", "service": "/flip", "md5sum": "bad"}
    with pytest.raises(h.Refusal, match=r"/x.*\[bad\] vs. \[09fb\]"):
        h.make_service_response(header, "/server", "/flip", SET_BOOL)
    odd = h.check_service_response({"md5sum": "bad"}, "/flip", SET_BOOL)
    assert odd.startswith("service /flip has md5sum [bad], but this client's std_srvs/SetBool has [09fb]")


@pytest.mark.parametrize(("text", "value"), [("1", True), ("true", True), ("True", True), ("0", False), (None, False)])
def test_flags(text: str | None, value: bool) -> None:
    assert h.is_true(text) is value
