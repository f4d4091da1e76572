"""What rules allow, and the settings that follow from message types."""

from __future__ import annotations

import pytest

from pyros1.bridge.names import Pattern, SharedName, parse_shared_name
from pyros1.bridge.rules.parsing import parse_config, rules_from_arguments
from pyros1.bridge.rules.rules import DEFAULT_MAX_SIZE, NEWEST_AGE, RELIABLE_AGE, Priority, Rule, RuleMatch, Rules


def sent(rules: Rules, local: str, *others: str) -> list[str]:
    return [str(outgoing.shared) for outgoing in rules.outgoing(local, others)]


def received(rules: Rules, name: str, sender: str) -> str:
    shared = parse_shared_name(name)
    rule = rules.incoming(shared, sender)
    return rule if isinstance(rule, str) else rules.local_name(rule, shared)


def test_own_topics_are_sent_to_all() -> None:
    rules = rules_from_arguments("red", ["/odom", "/camera/**"], [])
    assert sent(rules, "/odom") == ["red:/odom"] and sent(rules, "/camera/a") == ["red:/camera/a"]
    assert sent(rules, "/other") == []
    outgoing = rules.outgoing("/odom", [])[0]
    assert rules.receivers(outgoing, ["blue", "base", "red"]) == ["blue", "base"]


def test_topics_of_another_site_go_only_there() -> None:
    rules = rules_from_arguments("base", ["red:/cmd_vel"], [])
    assert sent(rules, "/red/cmd_vel") == ["red:/cmd_vel"] and sent(rules, "/cmd_vel") == []
    assert rules.receivers(rules.outgoing("/red/cmd_vel", [])[0], ["red", "blue"]) == ["red"]


def test_a_topic_of_each_other_site() -> None:
    rules = rules_from_arguments("base", ["*:/cmd_vel"], [])
    assert sent(rules, "/red/cmd_vel", "red", "blue") == ["red:/cmd_vel"]
    assert sent(rules, "/red/cmd_vel") == []


def test_denied_topics() -> None:
    rules = rules_from_arguments("red", ["/**", "!/secret/**"], ["*:**", "!base:/noise"])
    assert sent(rules, "/a") == ["red:/a"] and sent(rules, "/secret/a") == []
    assert received(rules, "base:/noise", "base") == "denied by a rule"
    assert received(rules, "base:/map", "base") == "/base/map"


def test_what_is_taken() -> None:
    rules = rules_from_arguments("red", [], ["/cmd_vel", "base:/map"])
    assert received(rules, "red:/cmd_vel", "base") == "/cmd_vel"
    assert received(rules, "base:/map", "base") == "/base/map"
    assert received(rules, "base:/cmd_vel", "base") == "no rule takes it"
    assert received(rules, "blue:/map", "base") == "base offers a topic of another site"
    assert received(rules_from_arguments("red", [], ["*:**"]), "red:/cmd_vel", "base") == "no rule takes it"


def test_prefixes_and_names() -> None:
    text = """
prefix: {blue: /, '*': /robots}
take:
  - '*:**'
send:
  - {topic: /odom, here: /base/odom}
  - {topic: 'blue:/camera/**', here: /front/**}
"""
    rules = parse_config(text, "f", "red").rules
    assert received(rules, "blue:/odom", "blue") == "/odom"
    assert received(rules, "green:/odom", "green") == "/robots/odom"
    assert sent(rules, "/base/odom") == ["red:/odom"] and sent(rules, "/odom") == []
    assert sent(rules, "/front/left/image") == ["blue:/camera/left/image"]
    text = "take: [{topic: 'base:/map', here: /map}, {topic: 'base:**', here: /station/**}]"
    rules = parse_config(text, "f", "red").rules
    assert received(rules, "base:/map", "base") == "/map" and received(rules, "base:/a/b", "base") == "/station/a/b"


def test_rules_for_some_sites() -> None:
    text = "send: [{topic: /odom, sites: [base]}]\ntake: [{topic: /goal, sites: base}]\nsites: [base, blue]"
    rules = parse_config(text, "f", "red").rules
    assert rules.receivers(rules.outgoing("/odom", [])[0], ["base", "blue", "green"]) == ["base"]
    assert (
        received(rules, "red:/goal", "base") == "/goal" and received(rules, "red:/goal", "blue") == "no rule takes it"
    )
    assert [rules.talks_to(site) for site in ("base", "blue", "green", "red")] == [True, True, False, False]


def test_two_rules_for_a_topic_give_the_settings_of_the_first() -> None:
    rules = rules_from_arguments("red", ["/scan@5", "/**@20"], [])
    assert [outgoing.rule.rate for outgoing in rules.outgoing("/scan", [])] == [5.0]


@pytest.mark.parametrize(
    ("type_name", "priority", "reliable", "age", "may_latch"),
    [
        ("std_msgs/String", Priority.NORMAL, False, NEWEST_AGE, True),
        ("geometry_msgs/Twist", Priority.URGENT, False, 0.5, False),
        ("sensor_msgs/Image", Priority.LOW, False, NEWEST_AGE, True),
        ("move_base_msgs/MoveBaseActionGoal", Priority.HIGH, True, RELIABLE_AGE, False),
        ("move_base_msgs/MoveBaseActionResult", Priority.HIGH, True, RELIABLE_AGE, True),
        ("actionlib_msgs/GoalID", Priority.HIGH, True, RELIABLE_AGE, False),
        ("tf2_msgs/TFMessage", Priority.NORMAL, True, NEWEST_AGE, True),
    ],
)
def test_settings_by_type(type_name: str, priority: Priority, reliable: bool, age: float, may_latch: bool) -> None:
    settings = Rule(Pattern("/x")).settings("/x", type_name)
    assert settings[:7] == ("/x", None, DEFAULT_MAX_SIZE, priority, reliable, age, may_latch)


def test_settings_of_a_rule_win() -> None:
    rule = Rule(Pattern("/x"), "", (), 5.0, 1000, Priority.BACKGROUND, True, 7.0)
    settings = rule.settings("/y", "geometry_msgs/Twist")
    assert settings[:7] == ("/y", 5.0, 1000, Priority.BACKGROUND, True, 7.0, False)


def test_a_topic_with_a_maximum_age_is_not_latched() -> None:
    assert [Rule(Pattern("/x"), age=age).settings("/x", "std_msgs/String").may_latch for age in (None, 7.0)] == [
        True,
        False,
    ]


def test_names_that_would_be_too_long() -> None:
    rules = rules_from_arguments("red", ["/**"], [])
    assert sent(rules, "/" + "a" * 300) == []
    assert RuleMatch(SharedName("red", "/a"), rules.send[0]).rule.pattern.text == "/**"
