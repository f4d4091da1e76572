"""--check in plain words."""

from __future__ import annotations

from pyros1.bridge.rules.explanation import explain
from pyros1.bridge.rules.parsing import SiteConfig, parse_config, rules_from_arguments


def test_a_robot() -> None:
    rules = rules_from_arguments("red", ["/odom", "/scan@5", "!/secret"], ["/cmd_vel"])
    assert [*explain(SiteConfig(rules, ("tcp/base:7447",)))] == [
        "site red: talks to all sites",
        "  connects to tcp/base:7447",
        "sends:",
        "  /odom to every site that takes it",
        "  /scan to every site that takes it, at most 5 messages per second",
        "  never /secret",
        "takes:",
        "  /cmd_vel, from every site that sends it here",
    ]


def test_a_base() -> None:
    text = """
sites: [red, blue]
listen: tcp/127.0.0.1:7447
prefix: {blue: /robots/blue}
send:
- red:/cmd_vel
- {topic: '*:/goal', delivery: reliable}
- {topic: /map, here: /map_server/map, sites: red, priority: low}
take: ['red:**', {topic: 'blue:/odom', age: 1, rate: 2, size: 2kB}, '*:/scan', {topic: /a, sites: red}]
deny_take: ['red:/noise']
"""
    assert [*explain(parse_config(text, "f", "base"))] == [
        "site base: talks to the sites red, blue",
        "  listens on tcp/127.0.0.1:7447",
        "sends:",
        "  /red/cmd_vel to red, as /cmd_vel there",
        "  /SITE/goal to each other site, as /goal there, all messages in order",
        "  /map_server/map as base:/map to red, low priority",
        "takes:",
        "  /** of red, as /red/** here",
        "  /odom of blue, as /robots/blue/odom here, at most 2 messages per second, messages of at most 2000 bytes, "
        "none older than 1 s",
        "  /scan of each other site, as /SITE/scan here",
        "  /a, from red",
        "  never red:/noise",
    ]


def test_conversions_and_frames() -> None:
    text = """
send:
- {topic: /camera/**, convert: jpeg, rate: 5}
- {topic: /front, convert: h264}
- {topic: /points, convert: voxel, voxel: 0.05}
- {topic: /scan, convert: every, every: 4}
take:
- {topic: 'red:/tf', here: /tf, prefix_frames: red, keep_frames: map}
- {topic: 'red:**', prefix_frames: red}
"""
    assert [*explain(parse_config(text, "f", "base"))][1:] == [
        "sends:",
        "  /camera/** to every site that takes it, as JPEG, quality 80 under NAME/compressed, at most 5 messages per "
        "second",
        "  /front to every site that takes it, as H.264 video of about 2 Mbit/s under NAME/h264",
        "  /points to every site that takes it, one point of each cube of 0.05 m",
        "  /scan to every site that takes it, only 1 of 4 points",
        "takes:",
        "  /tf of red, as /tf here, frames as red/NAME (but map)",
        "  /** of red, as /red/** here, frames as red/NAME",
    ]


def test_nothing() -> None:
    lines = [*explain(SiteConfig(rules_from_arguments("red", [], [])))]
    assert lines[1:] == ["sends nothing", "takes nothing"]


def test_one_site_is_named_as_one() -> None:
    assert next(explain(parse_config("sites: [base]", "f", "red"))) == "site red: talks to site base"
