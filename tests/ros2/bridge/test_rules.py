"""Which topics a bridge to ROS 2 may exchange."""

from __future__ import annotations

import pytest

from pyros1.ros2.bridge.rules import NEVER, NEVER_SERVICES, Ros2Rules, Ros2RulesError


def test_without_rules_everything_is_exchanged() -> None:
    rules = Ros2Rules()
    assert rules.sends("/a/b") and rules.takes("/a/b")
    assert not any(rules.sends(name) or rules.takes(name) for name in NEVER)


def test_the_log_of_ros1_must_be_named() -> None:
    for rules, ways in (
        (Ros2Rules(), "from ROS 2 to ROS 1"),
        (Ros2Rules(["/rosout", "/odom"]), "from ROS 1 to ROS 2"),
        (Ros2Rules(["/rosout"], ["/**"]), "from ROS 2 to ROS 1 and from ROS 1 to ROS 2"),
        (Ros2Rules(take=["/scan"]), "not exchanged"),
        (Ros2Rules(take=["!/rosout"]), "not exchanged"),
        (Ros2Rules(["/rosout*"]), "not exchanged"),
    ):
        assert rules.sends("/rosout") == ("to ROS 2" in ways) and rules.takes("/rosout") == ("to ROS 1" in ways)
        assert f"the log (/rosout): {ways}" in rules.explain()


def test_services_that_each_node_has_are_not_exchanged() -> None:
    rules = Ros2Rules()
    assert rules.serves("/map_server/load_map") and rules.calls("/map_server/load_map")
    never = [f"/node/{name}" for name in NEVER_SERVICES] + ["/fibonacci/_action/send_goal"]
    assert {"/node/get_loggers", "/node/bridge_status", "/node/describe_parameters"} < {*never}
    assert not any(rules.serves(name) or rules.calls(name) for name in never)


def test_rules_are_for_services_too() -> None:
    rules = Ros2Rules(["/clear", "/camera/**", "!/camera/reset"])
    assert rules.serves("/clear") and rules.serves("/camera/start")
    assert not rules.serves("/camera/reset") and not rules.serves("/other") and not rules.calls("/clear")
    assert Ros2Rules(take=["/plan"]).calls("/plan") and not Ros2Rules(take=["/plan"]).serves("/plan")


def test_only_what_is_named() -> None:
    rules = Ros2Rules(["/odom", "/camera/**", "!/camera/secret"])
    assert rules.sends("/odom") and rules.sends("/camera/image") and not rules.sends("/camera/secret")
    assert not rules.sends("/other") and not rules.takes("/odom")
    assert Ros2Rules(take=["/cmd_vel"]).takes("/cmd_vel") and not Ros2Rules(take=["/cmd_vel"]).sends("/cmd_vel")


def test_everything_but() -> None:
    rules = Ros2Rules(["!/secret"])
    assert rules.sends("/odom") and rules.takes("/odom") and rules.takes("/secret") and not rules.sends("/secret")


@pytest.mark.parametrize("word", ["odom", "red:/odom", "", "/a b", "!", "/" + "a" * 300])
def test_what_is_not_a_pattern(word: str) -> None:
    with pytest.raises(Ros2RulesError, match="is not a pattern of topics, services or nodes"):
        Ros2Rules([word])


def test_whose_parameters() -> None:
    everything = Ros2Rules()
    assert not everything.reconfigures("/arm") and everything.reads("/arm")
    rules = Ros2Rules(["/odom"], [], ["/arm/**", "!/arm/tool"])
    assert [each for each in ("/arm", "/arm/base", "/arm/tool", "/leg") if rules.reconfigures(each)] == [
        "/arm",
        "/arm/base",
    ]
    assert [each for each in ("/arm", "/arm/tool", "/leg") if rules.reads(each)] == ["/arm"]
    assert [each for each in ("/arm", "/leg") if Ros2Rules([], ["/leg/**"]).reads(each)] == ["/leg"]
    assert Ros2Rules([], ["/*/get_parameters"]).reads("/arm")
    with pytest.raises(Ros2RulesError):
        Ros2Rules([], [], ["arm"])


def test_explanation() -> None:
    *lines, services = Ros2Rules(["/odom", "!/x"], [], ["/arm/**"]).explain()
    assert services.startswith("never exchanged, services: */get_loggers, */set_logger_level, */tf2_frames, ")
    assert lines == [
        "from ROS 1 to ROS 2: /odom, but not /x",
        "from ROS 2 to ROS 1: nothing",
        "parameters of ROS 2 nodes for dynamic_reconfigure: /arm/**",
        "the log (/rosout): not exchanged",
        "never exchanged, topics: /rosout_agg, /parameter_events, /statistics",
    ]
