"""Which services are served and called, and which parameters others may read."""

from __future__ import annotations

import pytest

from pyros1.bridge.names import SharedName
from pyros1.bridge.rules.parsing import parse_config
from pyros1.bridge.rules.rules import Rule, Rules
from pyros1.bridge.rules.services import PARAMETERS, called, match_served, may_read


def rules(text: str) -> Rules:
    return parse_config(text, "f", "red").rules


@pytest.mark.parametrize(
    ("text", "local", "shared"),
    [
        ("serve: [/add]", "/add", "/add"),
        ("serve: [/add]", "/other", None),
        ("serve: ['/**']\ndeny_serve: [/add]", "/add", None),
        ("serve: ['/**']\ndeny_serve: [/add]", "/other", "/other"),
        ("serve: [{service: /plan, here: /planner/plan}]", "/planner/plan", "/plan"),
        ("serve: [{service: /plan, here: /planner/plan}]", "/plan", None),
        ("serve: [{service: /a/**, here: /b/**}]", "/b/x/y", "/a/x/y"),
        ("serve: ['/**']", PARAMETERS, None),
        ("send: ['/**']", "/add", None),
    ],
)
def test_served(text: str, local: str, shared: str | None) -> None:
    found = match_served(rules(text), local)
    assert (found and found.shared) == (shared and SharedName("red", shared))


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("call: ['base:/add']", True),
        ("call: ['*:**']", True),
        ("call: [{service: 'base:**', sites: [blue]}]", "no rule calls it"),
        ("call: ['base:**']\ndeny_call: ['*:/add']", "denied by a rule"),
        ("take: ['base:**']", "no rule calls it"),
        ("call: ['base:**']\nsites: {base: {serve: [/add]}}", True),
        ("call: ['base:**']\nsites: {base: {serve: ['/**'], deny_serve: [/add]}}", "base may not serve it"),
        ("call: ['base:**']\nsites: {base: {send: ['/**'], take: ['/**']}}", "base may not serve it"),
        ("call: ['base:**']\nsites: {base: }", True),
    ],
)
def test_called(text: str, found: str | bool) -> None:
    rule = called(rules(text), SharedName("base", "/add"), "base")
    assert isinstance(rule, Rule) if found is True else rule == found


def test_a_site_serves_only_its_own() -> None:
    assert (
        called(rules("call: ['*:**']"), SharedName("blue", "/add"), "base") == "base serves a service of another site"
    )
    assert called(rules("call: ['*:**']"), SharedName("red", "/add"), "base") == "base serves a service of another site"


@pytest.mark.parametrize(
    ("name", "allowed"),
    [
        ("/robot_description", True),
        ("/camera/fps", True),
        ("/camera/sub/a", True),
        ("/camera/password", False),
        ("/camera/password/old", False),
        ("/lidar", True),
        ("/lidar/rate", True),
        ("/lidar2", False),
        ("/", False),
    ],
)
def test_parameters(name: str, allowed: bool) -> None:
    text = "params: [/robot_description, '/camera/**', /lidar]\ndeny_params: [/camera/password]"
    assert may_read(rules(text), name) is allowed
    assert not may_read(rules(""), name)
