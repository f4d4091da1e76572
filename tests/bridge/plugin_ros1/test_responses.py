"""Responses and errors, which the plugin does not tell apart."""

from __future__ import annotations

from pyros1.bridge.plugin_ros1.responses import Responses
from pyros1.msgs.std_srvs.srv import Empty, SetBool


def test_a_response_of_the_type_is_one() -> None:
    responses = Responses("std_srvs/SetBool", SetBool._md5sum)
    assert responses.is_known and responses.error(b"\x01\x02\x00\x00\x00ok") is None
    assert responses.error(b"service crashed\x1b") == "service crashed\\x1b"
    assert responses.error(b"\x01\x02\x00\x00\x00ok!") is not None, "too long"
    assert responses.error(b"") == "the service has sent an empty response"
    assert Responses("std_srvs/Empty", Empty._md5sum).error(b"") is None
    assert Responses("std_srvs/Empty", Empty._md5sum).error(b"no") == "no"


def test_of_unknown_types_everything_is_a_response() -> None:
    for type_name, md5sum in (("nowhere_msgs/Strange", "0" * 32), ("std_srvs/SetBool", "0" * 32)):
        responses = Responses(type_name, md5sum)
        assert not responses.is_known and responses.error(b"crashed") is None
