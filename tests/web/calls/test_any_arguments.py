"""Pages may say anything: what is wrong is told, and nothing else happens."""

from __future__ import annotations

import json
from collections.abc import Callable
from importlib import import_module
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pyros1.ground.errors import Error
from pyros1.msgs.std_msgs.msg import Float64
from pyros1.web import calls, views
from pyros1.web.robot import Robot
from pyros1.web.server import wire

pytestmark = pytest.mark.once

FILES = ("actions", "bags", "doctor", "forms", "guide", "page", "params", "reconfigure", "scene", "services", "topics")
CALLS = sorted(f"{file}.{word}" for file in FILES for word in import_module(f"pyros1.web.calls.{file}").CALLS)
_WORDS = """topic type value latch begin service services timeout node logger level name yaml part action id path time
topics folder prefix compression values types curves windows frozen hz after run fixed rate loop paused clock start
times height columns end"""
_NAMES = st.sampled_from(_WORDS.split())
_TEXTS = ["", "/", "/wave", "/wave/data", "wave", "~x", "/a b", "\0", "\ud800", "std_msgs/Float64", "no/Such", "../x"]
_TEXTS += ["/etc/passwd", "now", "[", "&a [*a]", "- " * 300, "/wave: m.data**9", "/wave: " + "(" * 200, "x" * 3000]
_TEXTS += ["/wave: m.__class__", "/wave/data[99999999999]", "request", "lz4", "debug", "\x1b[31m"]
_NUMBERS = [None, True, 0, -1, 0.05, 1 << 70, 10**400, 1e308]
_VALUES = st.recursive(
    st.sampled_from(_TEXTS) | st.sampled_from(_NUMBERS),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(_NAMES, inner, max_size=3),
    max_leaves=6,
)
_ARGS = st.dictionaries(_NAMES, _VALUES, max_size=6)
_quick = settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


@pytest.fixture
def busy(robot: Robot, make_node: Callable[..., Any]) -> Robot:
    """A robot with a topic and a parameter."""
    node = make_node("talker")
    node.advertise("wave", Float64, latch=True).publish(1.0)
    node.params["/wave"] = 1
    return robot


@pytest.mark.slow
@pytest.mark.parametrize("name", CALLS)
@_quick
@given(args=_ARGS)
def test_calls(busy: Robot, name: str, args: dict[str, Any]) -> None:
    if "timeout" in args:
        args = {**args, "timeout": 0.1}
    try:
        found = calls.run(busy, name, args)
    except Error as error:
        assert str(error)
    else:
        json.loads(wire.result(1, found))


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(views.VIEW_NAMES))
@_quick
@given(first=_ARGS, second=_ARGS)
def test_views(busy: Robot, name: str, first: dict[str, Any], second: dict[str, Any]) -> None:
    try:
        view = views.view_class(name)(busy, first, lambda: None)
    except Error:
        return
    try:
        for step in (view.poll, lambda: view.change(second), view.poll):
            try:
                push = step()
            except Error as error:
                assert str(error)
            else:
                assert push is None or wire.push(1, push)
    finally:
        view.close()
