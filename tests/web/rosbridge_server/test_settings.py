"""The parameters of rosbridge_websocket."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pyros1.robot_nodes.shared.parameters import PrivateParameters
from pyros1.web.rosbridge.frame_decoder import MAX_FRAME
from pyros1.web.rosbridge_server.settings import Settings, UnsupportedError, options_in, read_patterns, read_settings


def parameters(**values: Any) -> PrivateParameters:
    return PrivateParameters(values, pytest.fail)


def test_defaults_and_values() -> None:
    assert read_settings(parameters()) == Settings()
    # What the launch file sets without arguments.
    launched = read_settings(
        parameters(max_message_size="None", topics_glob="[*]", services_glob="[*]", params_glob="[*]", address="")
    )
    assert launched == Settings(topics=("*",), services=("*",), parameters=("*",))
    read = read_settings(
        parameters(
            port=0,
            address="127.0.0.1",
            retry_startup_delay=5,
            certfile="a.pem",
            keyfile="b.pem",
            use_compression=True,
            max_message_size=1000,
            websocket_ping_interval=3,
            websocket_ping_timeout=4,
            websocket_null_origin=False,
        )
    )
    assert read == Settings(0, "127.0.0.1", 5.0, "a.pem", "b.pem", True, 1000, 3.0, 4.0, False)
    assert read_settings(parameters(max_message_size=10**12)).max_message_size == MAX_FRAME
    assert read_settings(parameters(websocket_ping_timeout=0)).ping_timeout == 30.0


@pytest.mark.parametrize(
    ("values", "text"),
    [
        ({"authenticate": True}, "authenticate is not supported"),
        ({"bson_only_mode": True}, "bson_only_mode is not supported"),
        ({"certfile": "a.pem"}, "certfile and keyfile must both be set"),
        ({"topics_glob": "/odom"}, "topics_glob must be a list of patterns"),
        ({"services_glob": 3}, "services_glob must be a list of patterns"),
        ({"params_glob": ["/a", 1]}, "params_glob must be a list of patterns"),
    ],
)
def test_what_must_not_be_ignored(values: dict[str, Any], text: str) -> None:
    with pytest.raises(UnsupportedError, match=text):
        read_settings(parameters(**values))


@pytest.mark.slow
@settings(max_examples=40)
@given(st.lists(st.from_regex(r"[a-z*?_/]{1,9}", fullmatch=True)), st.sampled_from(["", "'", '"']))
def test_patterns(patterns: list[str], quote: str) -> None:
    text = "[" + ", ".join(f"{quote}{pattern}{quote}" for pattern in patterns) + "]"
    assert read_patterns(parameters(globs=text), "globs") == tuple(patterns)
    assert read_patterns(parameters(globs=patterns), "globs") == tuple(patterns)


def test_options_of_the_command_line() -> None:
    words = "--port 9091 --address localhost --retry_startup_delay 0.5 --bson_only_mode --max_message_size None x"
    assert options_in(words.split()) == {
        "port": 9091,
        "address": "localhost",
        "retry_startup_delay": 0.5,
        "bson_only_mode": True,
        "max_message_size": "None",
    }
    with pytest.raises(UnsupportedError, match="--port needs a value"):
        options_in(["--port"])
