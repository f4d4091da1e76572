"""What the command line and the file say, and what it means in plain words."""

from __future__ import annotations

import pytest

from pyros1.bridge.plugin_ros1.config import make_config, names_dialect, parse_plugin_config
from pyros1.bridge.plugin_ros1.explanation import explain
from pyros1.bridge.rules.file_reader import RulesError

FILE = """\
dialect: zenoh-plugin-ros1
namespace: base
to: [tcp/robot:7447]
listen: tcp/127.0.0.1:7447
keys: base_keys
prefix: {robot1: /r1}
send:
- topic: robot1:/cmd_vel
  here: /joystick/cmd_vel
  priority: urgent
take:
- robot1:/odom@5
- topic: robot1:/camera/**
  here: /cam/**
  size: 2MB
- '*:/scan'
serve: [/spawn]
call:
- service: robot1:/reset
  here: /reset_robot
deny_take: ['robot1:/camera/raw']
deny_serve: [/spawn/secret]
"""


def test_a_file_and_its_explanation() -> None:
    config = parse_plugin_config(FILE, "base.yaml")
    assert config.keys == "base_keys"
    assert [*explain(config)] == [
        "talks to bridges of zenoh-plugin-ros1, in namespace base",
        "  connects to tcp/robot:7447",
        "  listens on tcp/127.0.0.1:7447",
        "sends:",
        "  /joystick/cmd_vel to namespace robot1, as /cmd_vel there, urgent priority",
        "takes:",
        "  /r1/odom from namespace robot1, as /odom there, at most 5 messages per second",
        "  /cam/** from namespace robot1, as /camera/** there, messages of at most 2000000 bytes",
        "  /NAMESPACE/scan from each namespace, as /scan there",
        "  never robot1:/camera/raw",
        "serves:",
        "  /spawn to namespace base",
        "  never /spawn/secret",
        "calls:",
        "  /reset_robot from namespace robot1, as /reset there",
    ]


def test_the_command_line_comes_first() -> None:
    file = parse_plugin_config("take: [/odom]\nnamespace: other", "file")
    config = make_config("base", ["/a"], ["/scan@2", "!/odom"], ["/s", "!/t"], [], file=file)
    assert config.rules.namespace == config.rules.services.site == "base"
    assert [*explain(config)][1:] == [
        "sends:",
        "  /a to namespace base",
        "takes:",
        "  /scan from namespace base, at most 2 messages per second",
        "  /odom from namespace base",
        "  never /odom",
        "serves:",
        "  /s to namespace base",
        "  never /t",
    ]
    config = make_config("", [], ["/odom"], [], [], old_keys=True)
    assert [*explain(config)] == [
        "talks to bridges of zenoh-plugin-ros1, older than March 2025, without a namespace",
        "sends nothing",
        "takes:",
        "  /odom from bridges of any namespace",
    ]
    assert parse_plugin_config("", "file").rules.namespace == "*"


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("dialect: other", "f:1: there is no dialect 'other'; use zenoh-plugin-ros1"),
        ("\nnamespace: a-b", "f:2: 'a-b' cannot be a namespace here"),
        ("site: red", "f:1: there is no setting 'site'"),
        ("take:\n- topic: /a\n  age: 1", "f:3: there is no setting 'age'"),
        ("send:\n- topic: /a\n  sites: [red]", "f:3: there is no setting 'sites'"),
        ("call:\n- topic: /a", "f:2: there is no setting 'topic'"),
        ("call:\n- here: /a", "f:2: a rule needs a service"),
        ("call:\n- service: a", "f:2: 'a' is not a pattern"),
        ("old_keys: 1", "f:1: expected true or false"),
        ("old_keys: true\nnamespace: red", "have no namespaces"),
    ],
)
def test_files_that_are_refused(text: str, problem: str) -> None:
    with pytest.raises(RulesError) as caught:
        parse_plugin_config(text, "f")
    assert problem in str(caught.value)


def test_words_that_are_refused() -> None:
    with pytest.raises(RulesError, match="not a pattern"):
        make_config("", [], ["odom"], [], [])
    with pytest.raises(RulesError, match="cannot be a namespace"):
        make_config("a/b", [], [], [], [])
    with pytest.raises(RulesError, match="no namespaces"):
        make_config("", [], ["robot1:/odom"], [], [], old_keys=True)


def test_which_files_are_of_a_dialect() -> None:
    assert names_dialect(FILE, "f") and not names_dialect("site: red", "f") and not names_dialect("", "f")
