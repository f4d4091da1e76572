"""wire.xmlrpc: values there and back, the refusals, and what hostile bytes do (M49, O12)."""

from __future__ import annotations

import contextlib
import datetime
import math
from typing import Any
from xmlrpc import client

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.ground.errors import ProtocolError, SerializationError, XmlRpcFault
from pyros1.wire import xmlrpc
from pyros1.wire.xmlrpc_scan import scan_call, scan_response

LIMITS = (xmlrpc.SCALAR_CONVERTERS, xmlrpc.MAX_DEPTH, xmlrpc.MAX_VALUES)

# XML normalises line ends, so \r does not survive, as it does not in stock.
texts = st.text(st.characters(exclude_categories=["Cs", "Cc"], exclude_characters="\ufffe\uffff")) | st.sampled_from(
    ["", " ", "\n a\t", "<&>'\"]]>", "&amp;lt;", "a]]>b"]
)
scalars = (
    st.integers(-(2**31), 2**31 - 1)
    | st.booleans()
    | st.floats(allow_nan=False)
    | texts
    | st.binary()
    | st.datetimes(datetime.datetime(1000, 1, 1)).map(lambda when: when.replace(microsecond=0))
)
values = st.recursive(scalars, lambda inner: st.lists(inner) | st.dictionaries(texts, inner), max_leaves=20)


def through_parser(body: bytes) -> list[Any]:
    reader = xmlrpc.Reader()
    reader.read(body)
    return reader.stack


@pytest.mark.slow
@given(st.lists(values, max_size=4))
def test_m49_calls_round_trip(params: list[Any]) -> None:
    body = xmlrpc.dumps_call("setParam", params)
    assert xmlrpc.loads_call(body) == ("setParam", params)
    assert through_parser(body) == params


@pytest.mark.slow
@given(values)
def test_m49_responses_round_trip(value: Any) -> None:
    body = xmlrpc.dumps_response(value)
    assert xmlrpc.loads_response(body) == value
    assert through_parser(body) == [value]


@pytest.mark.slow
@given(st.lists(values, max_size=4))
def test_the_standard_library_reads_what_we_write_and_we_what_it_writes(params: list[Any]) -> None:
    read, method = client.loads(xmlrpc.dumps_call("m", params), use_builtin_types=True)
    assert (method, list(read)) == ("m", params)
    theirs = by_client(params)
    assert xmlrpc.loads_call(theirs) == ("m", params)


def by_client(params: list[Any]) -> bytes:
    return client.dumps(tuple(params), "m").encode()


def test_the_short_cut_reads_nested_values() -> None:
    params = ["/node", [1, ["a", {"b": [2.5, {}], "c": []}], True], {"x": {"y": {"z": [[], [3]]}}}]
    for body in (by_client(params), xmlrpc.dumps_call("m", params)):
        assert scan_call(body, *LIMITS) == ("m", params)


@pytest.mark.slow
@given(st.lists(values, max_size=4), st.data())
def test_the_short_cut_reads_as_the_parser_or_gives_up(params: list[Any], data: st.DataObject) -> None:
    body = bytearray(by_client(params) if data.draw(st.booleans()) else xmlrpc.dumps_call("m", params))
    for _ in range(data.draw(st.integers(0, 3))):
        position = data.draw(st.integers(0, len(body) - 1))
        kind = data.draw(st.sampled_from(["change", "remove", "repeat"]))
        if kind == "change":
            body[position] = data.draw(st.sampled_from(b"<>/&; \n\r\0avx0\xff\xef"))
        elif kind == "remove":
            del body[position : position + data.draw(st.integers(1, 12))]
        else:
            body[position:position] = body[position : position + data.draw(st.integers(1, 40))]
    plain = scan_call(bytes(body), *LIMITS)
    if plain is not None:
        reader = xmlrpc.Reader()
        reader.read(bytes(body))
        assert (reader.method, repr(reader.stack)) == (plain[0], repr(plain[1]))


@given(st.binary() | st.text().map(str.encode))
def test_garbage_is_a_protocol_error(body: bytes) -> None:
    for load in (xmlrpc.loads_call, xmlrpc.loads_response):
        with pytest.raises(ProtocolError):
            load(body)


@pytest.mark.slow
@given(values, st.data())
def test_cut_and_damaged_bodies_give_a_value_or_a_protocol_error(value: Any, data: st.DataObject) -> None:
    body = xmlrpc.dumps_response(value)
    cut = body[: data.draw(st.integers(0, len(body) - 1))]
    with pytest.raises(ProtocolError):
        xmlrpc.loads_response(cut)
    damaged = bytearray(body)
    damaged[data.draw(st.integers(0, len(body) - 1))] = data.draw(st.integers(0, 255))
    with contextlib.suppress(ProtocolError):
        xmlrpc.loads_response(bytes(damaged))


def test_floats_keep_their_last_bit_and_their_oddities() -> None:
    for value in (0.1, 1e300, -0.0, 5e-324, math.inf, -math.inf):
        assert repr(xmlrpc.loads_response(xmlrpc.dumps_response(value))) == repr(value)
    assert math.isnan(xmlrpc.loads_response(xmlrpc.dumps_response(math.nan)))


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("<value>plain</value>", "plain"),
        ("<value> sp </value>", " sp "),
        ("<value></value>", ""),
        ("<value/>", ""),
        ("<value><i4>-7</i4></value>", -7),
        ("<value><i4>" + "1".zfill(32) + "</i4></value>", 1),
        ("<value><i8>8589934592</i8></value>", 2**33),
        ("<value><nil/></value>", None),
        ("<value><string/></value>", ""),
        ("<value><string>&#65;&quot;&apos;</string></value>", "A\"'"),
        ("<value><string><![CDATA[<x>]]></string></value>", "<x>"),
        ("<value><string>a<!-- note -->b</string></value>", "ab"),
        ("<value>\r\n<double>\r\n1.5</double>\r\n</value>", 1.5),
        ("<value><array><data/></array></value>", []),
        ("<value><struct/></value>", {}),
        ("<value><base64>YW\nJj</base64></value>", b"abc"),
        (
            "<value><dateTime.iso8601>20200102T03:04:05</dateTime.iso8601></value>",
            datetime.datetime(2020, 1, 2, 3, 4, 5),
        ),
    ],
)
def test_other_spellings_of_values(text: str, value: Any) -> None:
    body = f"<methodResponse><params><param>{text}</param></params></methodResponse>".encode()
    assert xmlrpc.loads_response(body) == value


@pytest.mark.parametrize(
    "text",
    [
        "<value><int>1.5</int></value>",
        "<value><int>" + "9" * 30 + "</int></value>",
        "<value><int>" + "1".zfill(33) + "</int></value>",
        "<value><int></int></value>",
        "<value><boolean>2</boolean></value>",
        "<value><double>x</double></value>",
        "<value><base64>a</base64></value>",
        "<value><dateTime.iso8601>now</dateTime.iso8601></value>",
        "<value><int>1</int><int>2</int></value>",
        "<value><array><data/></array><array><data/></array></value>",
        "<value><struct/><int>2</int></value>",
        "<value><array><data><value><int>1</int><int>2</int></value></data></array></value>",
        "<value><what>1</what></value>",
        "<value><array></array></value><value>1</value>",
        "<value><array><data><value>1</value></struct></value>",
        "<value><struct><member><name>a</name><value>1</value></member></data></array></value>",
        "<value><struct><member><value>1</value></member></struct></value>",
        "<value><struct><member><name>a</name></member></struct></value>",
        "<value><struct><member><name>a</name><name>b</name></member></struct></value>",
        "<value><struct><member><value>1</value><name>a</name></member></struct></value>",
        "<value><array><data></param><value>1</value></data></array></value>",
        "<value><struct></member><member><name>a</name><value>1</value></member></struct></value>",
        "<value><data></data></value>",
        "<param><value>1</value></param>",
        "<value>&unknown;</value>",
        "<value>\x01</value>",
        "",
    ],
)
def test_wrong_values_are_protocol_errors(text: str) -> None:
    body = f"<methodResponse><params><param>{text}</param></params></methodResponse>".encode()
    with pytest.raises(ProtocolError):
        xmlrpc.loads_response(body)
    assert scan_response(body, *LIMITS) is None


@pytest.mark.parametrize("code", [*range(9), 11, 12, *range(14, 32)])
def test_characters_that_xml_forbids_are_refused(code: int) -> None:
    with pytest.raises(ProtocolError):
        xmlrpc.loads_response(xmlrpc.dumps_response("a_b").replace(b"_", bytes([code])))


def test_entities_and_document_types_are_refused() -> None:
    bomb = '<!DOCTYPE a [<!ENTITY x "ha"><!ENTITY y "&x;&x;&x;&x;">]>'
    outside = '<!DOCTYPE a SYSTEM "file:///etc/hostname">'
    for doctype in (bomb, outside, "<!DOCTYPE a>"):
        body = f'<?xml version="1.0"?>{doctype}<methodCall><methodName>getPid</methodName><params/></methodCall>'
        with pytest.raises(ProtocolError):
            xmlrpc.loads_call(body.encode())


def test_depth_is_bounded_both_ways() -> None:
    value: Any = 1
    for _ in range(xmlrpc.MAX_DEPTH):
        value = [value]
    assert xmlrpc.loads_response(xmlrpc.dumps_response(value)) == value
    with pytest.raises(SerializationError, match="deep"):
        xmlrpc.dumps_response([value])
    with pytest.raises(SerializationError, match="deep"):
        xmlrpc.dumps_response({"a": value})
    for opening, closing in (
        ("<value><array><data>", "</data></array></value>"),
        ("<value><struct><member><name>a</name>", "</member></struct></value>"),
    ):
        many = xmlrpc.MAX_DEPTH + 1
        inner = opening * many + "<value>x</value>" + closing * many
        with pytest.raises(ProtocolError, match="deep"):
            xmlrpc.loads_response(f"<methodResponse><params><param>{inner}</param></params></methodResponse>".encode())


def test_the_number_of_values_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(xmlrpc, "MAX_VALUES", 10)
    assert xmlrpc.loads_response(xmlrpc.dumps_response([1] * 9)) == [1] * 9
    with pytest.raises(ProtocolError, match="more than 10"):
        xmlrpc.loads_response(xmlrpc.dumps_response([1] * 10))
    assert len(through_parser(xmlrpc.dumps_response([1] * 9))[0]) == 9
    with pytest.raises(ProtocolError, match="more than 10"):
        through_parser(xmlrpc.dumps_response([1] * 10))


@pytest.mark.parametrize(
    ("value", "reason"),
    [
        (2**31, "32 bits"),
        (-(2**31) - 1, "32 bits"),
        (None, "None"),
        ({1: 2}, "keys must be strings"),
        ("a\x00", "character"),
        ("\ud800", "character"),
        (object(), "object"),
        ({1, 2}, "set"),
    ],
)
def test_m49_values_that_cannot_be_sent(value: Any, reason: str) -> None:
    for whole in (value, [value], {"a": value}):
        with pytest.raises(SerializationError, match=reason):
            xmlrpc.dumps_response(whole)


def test_relatives_of_the_plain_types_are_sent_as_those() -> None:
    class Text(str):
        pass

    class Number(float):
        pass

    class Index:
        def __index__(self) -> int:
            return 7

    sent = [Text("a"), Number(1.5), Index(), (1, 2), bytearray(b"x"), memoryview(b"y"), client.Binary(b"z")]
    assert xmlrpc.loads_response(xmlrpc.dumps_response(sent)) == ["a", 1.5, 7, [1, 2], b"x", b"y", b"z"]


def test_faults() -> None:
    with pytest.raises(XmlRpcFault) as caught:
        xmlrpc.loads_response(xmlrpc.dumps_fault(-3, "no <such>\x00 thing"))
    assert (caught.value.code, caught.value.message) == (-3, "no <such>? thing")
    odd = b"<methodResponse><fault><value>text</value></fault></methodResponse>"
    with pytest.raises(ProtocolError):
        xmlrpc.loads_response(odd)


def test_bodies_of_the_other_kind_are_refused() -> None:
    with pytest.raises(ProtocolError):
        xmlrpc.loads_call(xmlrpc.dumps_response(1))
    with pytest.raises(ProtocolError):
        xmlrpc.loads_response(xmlrpc.dumps_call("m", [1]))
    with pytest.raises(ProtocolError):
        xmlrpc.loads_response(b"<methodResponse><params></params></methodResponse>")
