"""Fuzzers of what comes from the network: headers, frames, datagrams, HTTP and XML-RPC."""

from __future__ import annotations

import contextlib
import struct
from collections.abc import Callable, Iterator
from typing import Any

from pyros1.ground.errors import ConnectionRefusedByPeerError, ProtocolError, SerializationError, XmlRpcFault
from pyros1.wire import datagram, handshake
from pyros1.wire.framing import FrameBuffer
from pyros1.wire.header import HeaderReader, decode_header, encode_header
from pyros1.wire.http import HttpError, HttpLimits, RequestParser, ResponseParser, build_request, build_response
from pyros1.wire.service import RESPONSE_HEAD_SIZE, decode_response_head
from pyros1.wire.xmlrpc import (
    MAX_DEPTH,
    MAX_VALUES,
    SCALAR_CONVERTERS,
    Reader,
    dumps_call,
    dumps_fault,
    dumps_response,
    loads_call,
    loads_response,
)
from pyros1.wire.xmlrpc_scan import scan_call, scan_response

from . import bombs
from .fuzzer import MEGABYTE, Fuzzer, words

_TYPE = handshake.TopicType("std_msgs/String", "992ce8a1687cec8c8bd883ec73ca41d1", "string data\n")
_SERVICE = handshake.ServiceType("std_srvs/Empty", "0" * 32, "std_srvs/EmptyRequest", "std_srvs/EmptyResponse")


def pieces(data: bytes) -> Iterator[bytes]:
    """Yield bytes in pieces whose size the first byte decides."""
    step = data[0] or 4096 if data else 1
    for at in range(1, len(data), step):
        yield data[at : at + step]


def connection_header(data: bytes) -> None:
    """Read a header as it arrives, and give it to all who answer headers."""
    reader = HeaderReader(MEGABYTE)
    for piece in pieces(data):
        fields = reader.feed(piece)
        if fields is not None:
            break
    else:
        return
    assert decode_header(encode_header(fields)[4:]) == fields
    answers: list[Callable[[], object]] = [
        lambda: handshake.make_publisher_response(fields, "/n", "/t", _TYPE, False),
        lambda: handshake.check_publisher_response(fields, "/t", _TYPE, "/p"),
        lambda: handshake.make_service_response(fields, "/n", "/s", _SERVICE),
        lambda: handshake.check_service_response(fields, "/s", _SERVICE),
    ]
    for answer in answers:
        with contextlib.suppress(handshake.Refusal, ProtocolError, ConnectionRefusedByPeerError):
            answer()


def frames(data: bytes) -> None:
    """Receive frames; the claims of a peer cost nothing."""
    buffer = FrameBuffer(1 << 12, MEGABYTE)
    sent = b""
    for piece in pieces(data):
        buffer.feed(piece)
        sent += piece
        for start, stop in buffer.received(len(piece)):
            body = bytes(buffer.view[start:stop])
            assert sent.startswith(struct.pack("<I", len(body)) + body)
            sent = sent[4 + len(body) :]


def service_response(data: bytes) -> None:
    """Read the head of a service's answer."""
    if len(data) >= RESPONSE_HEAD_SIZE:
        _, size = decode_response_head(data[:RESPONSE_HEAD_SIZE], MEGABYTE)
        assert size <= MEGABYTE


def datagrams(data: bytes) -> None:
    """Put messages together from datagrams, and read both sides' words before them."""
    assembler = datagram.Assembler(0)
    for piece in pieces(data):
        body = assembler.feed(piece)
        assert body is None or len(body) < len(data)
    assert assembler.lost <= len(data)
    for said in (["UDPROS", data, "h", 5, 99], ["UDPROS", "h", 5, 7, 99, data], [*data]):
        with contextlib.suppress(ProtocolError):
            datagram.parse_udpros_offer(said)
        with contextlib.suppress(ProtocolError):
            datagram.parse_udpros_response(said)


Parser = RequestParser | ResponseParser


def _http(parser: Any, parts: Iterator[bytes]) -> tuple[list[tuple[Any, ...]], int | None]:
    """Return the messages that a parser finds, and the status of its error."""
    found: list[Any] = []
    status = None
    try:
        for part in parts:
            parser.feed(part)
            while (message := parser.next_message()) is not None:
                found.append(message)
            assert parser.num_buffered <= 2 * 4096 + len(part)
        if isinstance(parser, ResponseParser):
            last = parser.eof()
            found += [] if last is None else [last]
    except HttpError as error:
        status = error.status
        assert 400 <= status < 600
    return [tuple(getattr(each, name, None) for name in ("method", "path", "status", "body")) for each in found], status


def _both_ways(make: Callable[[HttpLimits], Parser], data: bytes) -> None:
    """Parse messages in pieces and byte by byte: the same messages come out."""
    limits = HttpLimits(1024, 4096)
    whole, status = _http(make(limits), pieces(data))
    single, other = _http(make(limits), (data[at : at + 1] for at in range(1, len(data))))
    assert whole == single and (status is None) == (other is None)


def http_request(data: bytes) -> None:
    """Parse requests."""
    _both_ways(RequestParser, data)


def http_response(data: bytes) -> None:
    """Parse answers."""
    _both_ways(ResponseParser, data)


def _same(one: Any, other: Any) -> bool:
    return repr(one) == repr(other)  # NaN is not equal to itself


def xmlrpc_call(data: bytes) -> None:
    """Read a call; the short cut reads what the parser reads."""
    short = scan_call(data, SCALAR_CONVERTERS, MAX_DEPTH, MAX_VALUES)
    if short is not None:
        reader = Reader()
        reader.read(data)
        assert _same((reader.method, reader.stack), short)
    method, params = loads_call(data)
    with contextlib.suppress(SerializationError):
        assert _same(loads_call(dumps_call(method, params)), (method, params))


def xmlrpc_response(data: bytes) -> None:
    """Read an answer; the short cut reads what the parser reads."""
    short = scan_response(data, SCALAR_CONVERTERS, MAX_DEPTH, MAX_VALUES)
    if short is not None:
        reader = Reader()
        reader.read(data)
        assert _same(reader.stack, short)
    value = loads_response(data)
    with contextlib.suppress(SerializationError):
        assert _same(loads_response(dumps_response(value)), value)


_VALUE: Any = ["a b", 1, 2.5, True, b"\0\xff", [], {}, [[{"k": ["v", -7]}]], {"x": {"y": "<&>"}}, "\u00e4\U0001f600"]
_HTTP = words(
    r"""
    \r\n  \n  \r\n\r\n  :\x20  Content-Length  Transfer-Encoding: chunked  HTTP/1.1  HTTP/1.0
    Connection: keep-alive  Connection: close  5\r\nabcde\r\n0\r\n\r\n  100  204  ;x=1  +5
    """
)
_XML = words(
    r"""
    <value>  </value>  <array><data>  </data></array>  <struct>  </struct>  <member>  <name>  </name>  </member>
    <param>  </param>  <params>  </params>  <string>  </string>  <int>  </int>  <i8>  <double>nan</double>
    <boolean>  <base64>  <nil/>  <dateTime.iso8601>  &lt;  &#0;  &#xd800;  <!--  -->  <![CDATA[  ]]>
    <!DOCTYPE a [<!ENTITY b 'c'>]>  <?x?>  <fault>  <?xml version='1.0' encoding='utf-16'?>  encoding='latin-1'
    \xef\xbb\xbf  xmlns='a'  1e999  _1
    """
)
_FIELDS = words(
    r"""
    topic=/t  service=/s  md5sum=*  type=std_msgs/String  callerid=/c  tcp_nodelay=1  error=no
    message_definition=  latching=1  probe=1  persistent=1  =  request_type=*  \xff\xfe  \n
    """
)
_HEADER = {
    "topic": "/t",
    "type": _TYPE.name,
    "md5sum": _TYPE.md5sum,
    "callerid": "/c",
    "message_definition": "string a",
}
_LENGTHS = [struct.pack("<I", number) for number in (0, 1, 4, 5, 100, 1 << 20, (1 << 32) - 1)]


def _datagrams() -> list[bytes]:
    split = datagram.split_frame(struct.pack("<I", 100) + bytes(100), 0, 3, 64)
    return [bytes([64]) + b"".join(split), b"\x40" + b"".join(reversed([*split]))]


def _xml_bombs(root: bytes) -> list[bytes]:
    before = b"<%s>%s<params><param>" % (root, b"<methodName>a</methodName>" if root == b"methodCall" else b"")
    after = b"</param></params></%s>" % root
    return [
        *bombs.entities(root, b"<params><param><value>%s</value></param></params>"),
        bombs.nested(b"<value><array><data>", b"</data></array></value>", before=before, after=after),
        bombs.nested(
            b"<value><struct><member><name>a</name>", b"</member></struct></value>", b"<value/>", before, after
        ),
        before + b"<value><int>" + b"9" * 100_000 + b"</int></value>" + after,
        before + b"<value><double>" + b"9" * 100_000 + b"</double></value>" + after,
    ]


FUZZERS = {
    "connection_header": Fuzzer(
        connection_header,
        (ProtocolError,),
        [*_LENGTHS, *_FIELDS],
        lambda: [b"\0" + encode_header(_HEADER), b"\1" + encode_header({"service": "/s", "md5sum": "*", "error": "x"})],
    ),
    "frames": Fuzzer(frames, (ProtocolError,), _LENGTHS, lambda: [b"\7" + _LENGTHS[2] + b"abcd" + _LENGTHS[0]]),
    "service_response": Fuzzer(service_response, (ProtocolError,), _LENGTHS, lambda: [b"\1\4\0\0\0"], largest=16),
    "datagrams": Fuzzer(datagrams, (), [*_LENGTHS, encode_header(_HEADER)[4:]], _datagrams),
    "http_request": Fuzzer(
        http_request,
        (),
        [*_HTTP, b"POST / HTTP/1.1\r\n", b"GET /", b"/RPC2", b"Origin: x", b"Host: h"],
        lambda: [b"\0" + build_request("h:1", "/", b"abc") * 2, b"\3GET / HTTP/1.0\r\n\r\n"],
    ),
    "http_response": Fuzzer(
        http_response,
        (),
        [*_HTTP, b"HTTP/1.1 200 OK\r\n", b"HTTP/1.1 100 Continue\r\n\r\n", b"HTTP/1.1 304"],
        lambda: [b"\0" + build_response(200, b"abc") * 2, b"\5HTTP/1.0 200 OK\r\n\r\nabc"],
    ),
    "xmlrpc_call": Fuzzer(
        xmlrpc_call,
        (ProtocolError,),
        [*_XML, b"<methodCall>", b"</methodCall>", b"<methodName>a</methodName>"],
        lambda: [*(dumps_call("getParam", ["/n", value]) for value in _VALUE), *_xml_bombs(b"methodCall")],
        largest=1 << 14,
    ),
    "xmlrpc_response": Fuzzer(
        xmlrpc_response,
        (ProtocolError, XmlRpcFault),
        [*_XML, b"<methodResponse>", b"</methodResponse>", b"</fault>", b"faultCode", b"faultString"],
        lambda: [
            *(dumps_response([1, "ok", value]) for value in _VALUE),
            dumps_fault(-1, "no"),
            *_xml_bombs(b"methodResponse"),
        ],
        largest=1 << 14,
    ),
}
