"""What rosbridge_suite makes of clients' messages and of questions to rosapi, and what we do.

`interop/web/record_rosbridge.py` has recorded it.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from pyros1.ground.errors import Error
from pyros1.ground.timing import Time
from pyros1.msgs import load_message, load_service
from pyros1.web.robot import Robot
from pyros1.web.rosbridge import frames, rosapi, values

from ...bodies import encode

RECORD = json.loads(Path(__file__).with_name("suite.json").read_text())
NOW = Time(*RECORD["now"])


def test_messages() -> None:
    for kind, what, given, expected in RECORD["conversions"]:
        convert: Callable[..., Any] = values.from_client if what == "message" else values.from_args
        cls = load_message(kind) if what == "message" else load_service(kind)._request_class
        try:
            body = encode(convert(cls, given, NOW))
        except Error:
            found = None
        else:
            found = json.loads(frames.to_json(values.decode(cls, body)))
        assert found == expected or expected is None, (kind, given)  # what the suite refuses may be accepted


@pytest.mark.parametrize("service", ["message_details", "service_request_details", "service_response_details"])
def test_definitions(robot: Robot, service: str) -> None:
    for name, kind, expected in RECORD["definitions"]:
        if name != service:
            continue
        try:
            found = rosapi.run(robot, f"/rosapi/{name}", {"type": kind})["typedefs"]
        except Error:
            found = None
        assert found == expected, kind


def test_defaults_of_parameters(robot: Robot) -> None:
    for default, expected in RECORD["defaults"]:
        found = rosapi.run(robot, "/rosapi/get_param", {"name": "/unset", "default": default})
        assert json.loads(found["value"]) == json.loads(expected), default
