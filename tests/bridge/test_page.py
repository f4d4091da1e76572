"""The commands and the file of the how-to page mean what it says."""

from __future__ import annotations

import re
import shlex
from pathlib import Path
from typing import Any

import pytest

import pyros1
from pyros1.bridge.plugin_ros1.config import parse_plugin_config
from pyros1.bridge.plugin_ros1.explanation import explain as explain_dialect
from pyros1.bridge.rules.explanation import explain
from pyros1.bridge.rules.parsing import parse_config
from pyros1.bridge.rules.router_config import explain_router, parse_router_config
from pyros1.cli.running import run_command

TEXT = (Path(pyros1.__file__).parent / "guide" / "howto" / "sites.md").read_text(encoding="utf-8")
COMMANDS = re.findall(r"^\w+\$ pyros1 bridge (--site .*)$", TEXT, re.M)
EXPECTED = [
    "  /** of each other site, as /SITE/** here",
    "  /cmd_vel, from every site that sends it here",
    "  /cmd_vel, from every site that sends it here",
    "  /spawn, by every site that calls it",
    "  /** of red, as /red/** here",
]
"""What --check says of each command, among other lines."""


def test_there_are_commands() -> None:
    assert len(COMMANDS) == len(EXPECTED)


@pytest.mark.parametrize(("line", "expected"), [*zip(COMMANDS, EXPECTED, strict=False)])
def test_commands(line: str, expected: str, call_main: Any) -> None:
    code, out, err = call_main(lambda words: run_command("bridge", words), *shlex.split(line), "--check")
    assert code == 0 and expected in out.splitlines()
    assert not err or (err.startswith("WARNING: ") and err.count("\n") == 1 and "--keys" in line), (
        "there are no keys here"
    )


def test_the_command_for_another_dialect(call_main: Any) -> None:
    (line,) = re.findall(r"^base\$ pyros1 bridge (--dialect .*)$", TEXT, re.M)
    code, out, err = call_main(lambda words: run_command("bridge", words), *shlex.split(line), "--check")
    assert (code, err) == (0, "") and out.splitlines() == [
        "talks to bridges of zenoh-plugin-ros1, without a namespace",
        "  connects to tcp/127.0.0.1:7447",
        "sends:",
        "  /cmd_vel to bridges of any namespace",
        "takes:",
        "  /odom from bridges of any namespace",
        "calls:",
        "  /reset from bridges of any namespace",
    ]


def test_the_file_for_another_dialect() -> None:
    (text,) = re.findall(r"```yaml\n(# robot.yaml.*?)```", TEXT, re.S)
    assert [*explain_dialect(parse_plugin_config(text, "robot.yaml"))][2:] == [
        "sends:",
        "  /robot1/cmd_vel to namespace robot1, as /cmd_vel there",
        "takes:",
        "  /odom from namespace robot1, at most 10 messages per second",
        "  never robot1:/rosout",
        "calls:",
        "  /reset_robot from namespace robot1, as /reset there",
    ]


def test_the_file() -> None:
    (text,) = re.findall(r"```yaml\n(# base.yaml.*?)```", TEXT, re.S)
    assert [*explain(parse_config(text, "base.yaml"))] == [
        "site base: talks to the sites red, blue",
        "  listens on tls/0.0.0.0:7447",
        "  proves its name with the keys in base, and requires certificates from others",
        "  considers a site lost that has not responded for 2 s",
        "sends:",
        "  /joystick/cmd_vel to red, as /cmd_vel there, urgent priority",
        "  /plan to red, all messages in order",
        "  /dome/image_raw to every site that takes it, as JPEG, quality 80 under NAME/compressed",
        "takes:",
        "  /** of red, as /** here",
        "  /camera/** of blue, as /blue_camera/** here, at most 5 messages per second, messages of at most 2000000 "
        "bytes, none older than 1 s",
        "  /tf of blue, as /tf here, frames as blue/NAME (but map)",
        "  never red:/rosout",
        "provides services of others:",
        "  /move_base/** of red, as /move_base/** here, at most 10 s for a call",
    ]


def test_what_sites_may_do() -> None:
    (text,) = re.findall(r"```yaml\n(sites:.*?)```", TEXT, re.S)
    assert [*explain_router(parse_router_config(text, "f"))] == [
        "a router for red, blue, base, hub, green",
        "  red may send /odom, /scan",
        "  red may take /cmd_vel",
        "  red may serve nothing",
        "  red may call nothing",
        "  blue may send /odom",
        "  blue may take *:/odom, base:/map",
        "  blue may serve /dock",
        "  blue may call base:/plan",
        "  hub forwards packets from and to green",
    ]


def test_the_router(call_main: Any) -> None:
    (line,) = re.findall(r"^server\$ pyros1 bridge (router .*)$", TEXT, re.M)
    code, out, err = call_main(lambda words: run_command("bridge", words), *shlex.split(line), "--check")
    assert (code, err) == (0, "") and out.startswith("a router for red, blue, base\n  listens on tls/[::]:7447\n")


def test_the_table_of_conversions() -> None:
    rows = re.findall(r"^\| (`convert: .*?`) \|", TEXT, re.M)
    rules = [", ".join(re.findall(r"`(.*?)`", row)) for row in rows]
    text = "send:\n" + "".join(f"- {{topic: /a, {rule}}}\n" for rule in rules)
    kinds = [rule.convert.kind for rule in parse_config(text, "f", "red").rules.send if rule.convert]
    assert kinds == ["jpeg", "png", "h264", "voxel", "every"]
