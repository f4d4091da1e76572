"""Parameters, as far as pages may see them."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from pyros1.ground.errors import ParameterNotSetError
from pyros1.web import calls
from pyros1.web.robot import Robot
from pyros1.web.rosbridge import rosapi
from pyros1.web.server.wire import RequestError

TREE = {"gain": 1, "secret": 2, "deep": {"secret": 3}}


@pytest.fixture
def limited(make_robot: Callable[..., Robot]) -> Robot:
    """A robot of which pages see gains and what is in /open."""
    robot = make_robot(topics=("*/gain", "/open", "/open/*"))
    robot.master.set_param("/arm", TREE)
    robot.master.set_param("/open", {"a": 1, "b": {"c": 2}})
    return robot


def test_without_limits_all_is_there(robot: Robot) -> None:
    robot.parameters.set("arm/", TREE)
    assert robot.parameters.get("//arm") == TREE == robot.parameters.get("/")["arm"]
    assert robot.parameters.has("/arm/deep") and "/arm/deep/secret" in robot.parameters.names()
    robot.parameters.delete("/arm/deep")
    assert not robot.parameters.has("/arm/deep")
    with pytest.raises(ParameterNotSetError):
        robot.parameters.get("/arm/deep")


def test_of_a_namespace_only_that_is_shown_which_pages_may_see(limited: Robot) -> None:
    assert limited.parameters.get("/arm") == {"gain": 1}
    assert limited.parameters.get("/") == {"arm": {"gain": 1}, "open": {"a": 1, "b": {"c": 2}}}
    assert limited.parameters.names() == ["/arm/gain", "/open/a", "/open/b/c"]
    assert calls.run(limited, "params.tree", {}) == {"/arm/gain": 1, "/open/a": 1, "/open/b/c": 2}
    assert calls.run(limited, "params.get", {"name": "/arm"}) == "gain: 1\n"
    assert rosapi.run(limited, "/rosapi/get_param", {"name": "/arm"}) == {"value": '{"gain":1}'}
    assert limited.parameters.has("/arm") and not limited.parameters.has("/arm/deep")
    for name in ("/arm/deep", "/arm/secret", "arm/secret", "//arm//secret", "/nothing"):
        with pytest.raises(RequestError, match="--topics"):
            limited.parameters.get(name)
    with pytest.raises(ParameterNotSetError):
        limited.parameters.get("/open/nothing")


def test_nothing_is_replaced_or_deleted_that_pages_may_not_see(limited: Robot) -> None:
    parameters = limited.parameters
    for name in ("/arm", "/arm/deep", "/arm/secret", "/", "/nothing"):
        with pytest.raises(RequestError, match="--topics"):
            parameters.delete(name)
        with pytest.raises(RequestError, match="--topics"):
            parameters.set(name, {"gain": 5} if name != "/nothing" else {"other": 1})
    with pytest.raises(RequestError, match="--topics"):
        parameters.set("/arm/secret/gain", 5)  # it would take the place of a value
    with pytest.raises(RequestError, match="--topics"):
        calls.run(limited, "params.delete", {"name": "/arm"})
    assert limited.master.get_param("/arm") == TREE
    parameters.set("/arm/gain", {"gain": 7})
    parameters.set("/open", {"a": {"x": 1}})
    parameters.set("/new/gain", 1)
    parameters.delete("/arm/gain/gain")
    parameters.delete("/open")
    assert limited.master.get_param("/arm") == {**TREE, "gain": {}}
    assert not limited.master.has_param("/open") and limited.master.get_param("/new") == {"gain": 1}
