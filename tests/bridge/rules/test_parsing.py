"""Rules from command lines and files. Errors say where they are."""

from __future__ import annotations

import pytest

from pyros1.bridge.rules.parsing import (
    RulesError,
    SiteConfig,
    add_arguments,
    parse_config,
    parse_topic,
    rules_from_arguments,
)
from pyros1.bridge.rules.rules import Priority
from pyros1.ground.errors import Error

FILE = """
site: red
to: tcp/base:7447
listen: [tcp/127.0.0.1:1, tcp/127.0.0.1:2]
sites: [base, blue]
loss: 1.5
prefix:
  base: /
  "*": /others
send:
  - /odom
  - /scan@5
  - topic: /camera/**
    rate: 10
    size: 2MB
    priority: low
    delivery: newest
    age: 0.5
    sites: [base]
deny_send: [/camera/debug]
take:
  - {topic: base:/map, here: /map, age: 9}
deny_take: ['base:/noise']
"""


def test_words() -> None:
    allows, rule = parse_topic("/scan@5")
    assert allows and rule.pattern.text == "/scan" and rule.rate == 5.0
    assert parse_topic("/scan@0.5")[1].rate == 0.5
    allows, rule = parse_topic("!/camera/**")
    assert not allows and rule.pattern.text == "/camera/**"


@pytest.mark.parametrize("word", ["scan", "/scan@", "/scan@0", "/scan@-1", "/scan@nan", "/scan@inf", "/a@5@6", "!/a@5"])
def test_words_that_are_wrong(word: str) -> None:
    with pytest.raises(RulesError):
        parse_topic(word)


def test_a_file() -> None:
    config = parse_config(FILE, "red.yaml")
    rules = config.rules
    assert (rules.site, config.connect, len(config.listen)) == ("red", ("tcp/base:7447",), 2)
    assert [config.places[each] for each in (*config.connect, *config.listen)] == ["red.yaml:3"] + ["red.yaml:4"] * 2
    assert (
        rules.loss_delay == 1.5 and rules.sites == ("base", "blue") and rules.prefixes == {"base": "", "*": "/others"}
    )
    camera = rules.send[2]
    assert (camera.rate, camera.max_size, camera.priority, camera.reliable) == (10.0, 2_000_000, Priority.LOW, False)
    assert (camera.age, camera.sites) == (0.5, ("base",))
    assert [pattern.text for pattern in rules.deny_send + rules.deny_take] == ["/camera/debug", "base:/noise"]
    assert rules.take[0].here == "/map" and rules.take[0].age == 9.0
    assert parse_config("", "f", "red") == SiteConfig(rules_from_arguments("red", [], []))
    assert parse_config(FILE, "red.yaml", "green").rules.site == "green"


def test_frames_and_conversions() -> None:
    text = """
take: [{topic: 'red:**', prefix_frames: fleet/red, keep_frames: [map, earth]}]
send:
- {topic: /camera, convert: jpeg, quality: 50}
- {topic: /depth, convert: png}
- {topic: /front, convert: h264}
- {topic: /points, convert: voxel, voxel: 0.1}
- {topic: /scan, convert: every, every: 4}
"""
    rules = parse_config(text, "f", "base").rules
    assert (rules.take[0].prefix_frames, rules.take[0].keep_frames) == ("fleet/red", ("map", "earth"))
    assert [rule.convert for rule in rules.send] == [
        ("jpeg", 50.0),
        ("png", 0.0),
        ("h264", 2e6),
        ("voxel", 0.1),
        ("every", 4.0),
    ]


def test_a_command_line_adds_to_a_file() -> None:
    config = add_arguments(parse_config(FILE, "red.yaml"), ["/odom@1", "!/secret"], ["/cmd_vel"])
    assert [rule.pattern.text for rule in config.rules.send][:2] == ["/odom", "/odom"]
    assert config.rules.send[0].rate == 1.0 and config.rules.deny_send[0].text == "/secret"
    assert config.rules.take[0].pattern.text == "/cmd_vel" and config.connect == ("tcp/base:7447",)


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("send: [", "f.yaml:1: "),
        ("- a", "f.yaml:1: expected a mapping"),
        ("site: red\nsend:\n  - /a\n  - b", "f.yaml:4: 'b' is not a pattern"),
        ("site: red\nsand: []", "f.yaml:2: there is no setting 'sand' (did you mean 'send'?)"),
        ("site: red\ntake:\n- topic: /a\n  prefix_frames: a b", "f.yaml:4: 'a b' is not the name of a frame"),
        ("site: red\ntake:\n- topic: /a\n  keep_frames: [map]", "f.yaml:4: keep_frames is only for rules with"),
        (
            "site: red\nsend:\n- topic: /a\n  prefix_frames: red",
            "f.yaml:4: the site that takes the topic decides on",
        ),
        ("site: red\ntake:\n- topic: /a\n  convert: jpeg", "f.yaml:4: the site that sends the topic decides on"),
        (
            "site: red\nsend:\n- topic: /a\n  convert: jpg",
            "f.yaml:4: there is no conversion 'jpg' (did you mean 'jpeg'?",
        ),
        ("site: red\nsend:\n- topic: /a\n  convert: jpeg\n  quality: 0", "f.yaml:5: quality must be a whole number"),
        ("site: red\nsend:\n- topic: /a\n  convert: png\n  quality: 9", "f.yaml:5: quality is only for convert: jpeg"),
        ("site: red\nsend:\n- topic: /a\n  convert: voxel", "f.yaml:4: convert: voxel needs voxel (edge of a cube"),
        ("to: tcp/x:1", "f.yaml:1: the file does not say which site it is for"),
        ("site: 7", "f.yaml:1: expected a string"),
        ("site: r-d", "f.yaml:1: 'r-d' cannot be a site's name"),
        ("site: red\nsend:\n- topic: /a\n  rate: fast", "f.yaml:4: rate must be a number above 0"),
        ("site: red\nsend:\n- topic: /a\n  rate: 0", "f.yaml:4: rate must be a number above 0"),
        ("site: red\nsend:\n- topic: /a\n  rate: true", "f.yaml:4: rate must be a number above 0"),
        ("site: red\nsend:\n- topic: /a\n  age: .inf", "f.yaml:4: age must be a number above 0"),
        ("site: red\nsend:\n- topic: /a\n  size: 2QB", "f.yaml:4: '2QB' is not a size"),
        ("site: red\nsend:\n- topic: /a\n  size: 65MiB", "f.yaml:4: '65MiB' is not a size"),
        (
            "site: red\nsend:\n- topic: /a\n  priority: hihg",
            "f.yaml:4: there is no priority 'hihg' (did you mean 'high'?)",
        ),
        ("site: red\nsend:\n- topic: /a\n  delivery: fast", "f.yaml:4: delivery must be reliable"),
        ("site: red\ntake:\n- topic: /a\n  delivery: newest", "f.yaml:4: the site that sends the topic decides on"),
        ("site: red\nsend:\n- rate: 5", "f.yaml:3: a rule needs a topic"),
        ("site: red\nsend:\n- '!/a'", "f.yaml:3: write topics that are not allowed under deny_send"),
        ("site: red\nsend:\n- 5", "f.yaml:3: expected a topic, such as /odom, or a rule"),
        ("site: red\nsend:\n- /a\n-", "f.yaml:4: expected a topic, such as /odom, or a rule"),
        ("site: red\ntake:\n- topic: base:/a\n  here: b", "f.yaml:4: 'b' is not the full name of a topic"),
        ("site: red\ntake:\n- topic: base:/a/**\n  here: /b", "f.yaml:4: `here` must end in /** if the pattern does"),
        ("site: red\ntake:\n- topic: base:/*\n  here: /b/**", "f.yaml:4: `here` must end in /** if the pattern does"),
        ("site: red\nloss: 0.9", "f.yaml:2: loss must be a number of seconds from 1 to 60, not 0.9"),
        ("site: red\nloss: .inf", "f.yaml:2: loss must be"),
        ("site: red\nloss: fast", "f.yaml:2: loss must be"),
        ("site: red\nprefix: /a", "f.yaml:2: expected a mapping"),
        ("site: red\nprefix:\n  base: a", "f.yaml:3: 'a' is not a full name"),
        ("site: red\nprefix:\n  b-b: /a", "f.yaml:3: 'b-b' cannot be a site's name"),
        ("site: red\nto: x", "f.yaml:2: 'x' is not an endpoint"),
        ("site: red\nlisten: [tcp/x:1,\n tls/x]", "f.yaml:3: 'tls/x' is not an endpoint"),
        ("site: red\ndeny_send: [/a]\ndeny_send: [/b]", "f.yaml:3: 'deny_send' was already set in line 2"),
        ("site: red\nsend:\n- topic: /a\n  topic: /b", "f.yaml:4: 'topic' was already set in line 3"),
        ("site: red\nsites: [b-b]", "f.yaml:2: 'b-b' cannot be a site's name"),
    ],
)
def test_errors_say_where(text: str, complaint: str) -> None:
    with pytest.raises(Error) as caught:
        parse_config(text, "f.yaml")
    assert str(caught.value).startswith(complaint)


@pytest.mark.parametrize("text", ["take: [*:/odom]", "take:\n- *:/odom", "send: [/a, !/b]", "deny_send:\n- !/b"])
def test_names_that_yaml_wants_in_quotation_marks(text: str) -> None:
    with pytest.raises(Error, match=r"^f\.yaml:\d: .*; quote names that begin with \* or !"):
        parse_config(text, "f.yaml", "red")
