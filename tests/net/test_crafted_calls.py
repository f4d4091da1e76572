"""CVE-2021-37146: calls whose XML let the server of stock's roscpp loop for ever; here each is read in bounded time."""

from __future__ import annotations

import socket
import time
from typing import Any

import pytest

from pyros1.net.hosts import parse_uri
from pyros1.net.xmlrpc_client import XmlRpcClient
from pyros1.wire.http import build_request

BEGIN = b'<?xml version="1.0"?><methodCall><methodName>getPid</methodName>'
VALUE = BEGIN + b"<params><param><value>"
CRAFTED = {
    "params that do not end": BEGIN + b"<params>",
    "a parameter that does not end": BEGIN + b"<params><param>",
    "no parameter in params": BEGIN + b"<params><value>/n</value></params></methodCall>",
    "an array that does not end": VALUE + b"<array><data>",
    "an array whose value does not end": VALUE + b"<array><data><value>",
    "an array without data": VALUE + b"<array><value>1</value></array></value></param></params></methodCall>",
    "ends in a wrong order": VALUE + b"<array><data></array></data></value></param></params></methodCall>",
    "a struct that does not end": VALUE + b"<struct><member><name>a</name>",
    "a member without a value": VALUE + b"<struct><member></member></struct></value></param></params></methodCall>",
    "members that are none": VALUE + b"<struct><value/></struct></value></param></params></methodCall>",
    "a tag without an end": VALUE + b"<array",
    "a comment without an end": VALUE + b"<!--",
    "one value after another": VALUE + b"</value><value>" * 20_000,
    "deep arrays": VALUE + b"<array><data><value>" * 20_000,
    "a name without an end": b'<?xml version="1.0"?><methodCall><methodName>',
    "nothing": b"",
    "zeros": bytes(100_000),
}
LIMIT = 5.0
"""Seconds for each, on a loaded machine."""


@pytest.mark.parametrize("body", CRAFTED.values(), ids=CRAFTED)
@pytest.mark.parametrize("of_node", [False, True], ids=["master", "node"])
def test_a_crafted_call_is_answered_in_time(master: Any, make_node: Any, body: bytes, of_node: bool) -> None:
    uri = make_node("node").uri if of_node else master.uri
    spent = time.process_time()
    with socket.create_connection(parse_uri(uri), timeout=60) as sock:
        sock.sendall(build_request("h", "/", body))
        answer = sock.recv(65536)
    assert answer.startswith(b"HTTP/1.1 ") and any(
        word in answer for word in (b"<fault>", b"<int>-1</int>", b"HTTP/1.1 4")
    ), answer
    client = XmlRpcClient(uri)
    assert client.call("getPid", "/caller")[0] == 1, "others are answered"
    client.close()
    assert time.process_time() - spent < LIMIT
