"""Callbacks that raise, and callbacks that do not return: the node's other callbacks go on, and its end is bounded."""

from __future__ import annotations

import signal
import sys
import time
from pathlib import Path

import pytest
from harness import Master, Process

MASTERS = ("ours",)
TEXT, FLIP = "std_msgs/String", "std_srvs/SetBool"

RAISES = """
import sys
from pyros1 import Node
topic = sys.argv[1]
def say(*words):
    sys.stdout.write(" ".join(words) + "\\n")  # one system call: threads do not share lines
def bad(what):
    def call(*_):
        say("called", what)
        raise ValueError(f"bad {what}")
    return call
with Node("clumsy") as node:
    node.on_shutdown(bad("hook"))
    node.subscribe(f"{topic}/bad", "std_msgs/String", bad("message"))
    node.subscribe(f"{topic}/good", "std_msgs/String", lambda message: say("good", message.data))
    node.advertise_service(f"{topic}/flip", "std_srvs/SetBool", bad("service"))
    node.timer(0.2, bad("timer"))
    node.params.cached(f"{topic}/param", 0)
    node.params.on_update(bad("parameter"))
    node.advertise(f"{topic}/peers", "std_msgs/String").watch(bad("joined"), bad("left"))
    say("ready")
    node.spin()
say("over")
"""

BLOCKS = """
import sys, time
from pyros1 import Node
topic = sys.argv[1]
def say(*words):
    sys.stdout.write(" ".join(words) + "\\n")  # one system call: threads do not share lines
def stuck(what):
    def call(*_):
        say("stuck", what)
        time.sleep(600)
    return call
with Node("stuck") as node:
    node.subscribe(f"{topic}/stuck", "std_msgs/String", stuck("message"))
    node.subscribe(f"{topic}/good", "std_msgs/String", lambda message: say("good", message.data))
    node.advertise_service(f"{topic}/stuck", "std_srvs/SetBool", stuck("service"))
    node.advertise_service(f"{topic}/flip", "std_srvs/SetBool", lambda request: (request.data, ""))
    node.timer(0.2, stuck("timer"))
    node.timer(0.2, lambda _: say("tick"))
    node.params.cached(f"{topic}/param", 0)
    node.params.on_update(stuck("parameter"))
    say("ready")
    node.spin()
"""


def start(launcher: Master, text: str, topic: str) -> Process:
    program = Path(launcher.home) / f"callbacks{len(launcher.processes)}.py"
    program.write_text(text)
    process = launcher.run([sys.executable, str(program), topic], python="ours", label="program")
    process.wait_line("^ready$", 20)
    return process


@pytest.mark.parametrize("kind", ["roscpp", "rospy"])
def test_callbacks_that_raise(launcher: Master, topic: str, kind: str) -> None:
    node, peer = start(launcher, RAISES, topic), launcher.ready_peer(kind, "peer")
    for name in ("bad", "good"):
        peer.advertise(f"{topic}/{name}", TEXT)
        peer.linked(f"{topic}/{name}")
    peer.subscribe(f"{topic}/peers", TEXT)
    peer.linked(f"{topic}/peers")
    for seed in (1, 2):
        peer.publish(f"{topic}/bad", seed)
        node.wait_line("^called message$", 20)
        peer.call_failing(f"{topic}/flip", FLIP)
        node.wait_line("^called service$", 20)
        peer.ask("setparam", f"{topic}/param", ("int", "float")[seed - 1], event=f"set {topic}/param")
        node.wait_line("^called parameter$", 20)
        node.wait_line("^called timer$", 20)
        peer.publish(f"{topic}/good", seed)
        node.wait_line("^good ", 20)
    peer.ask("unsub", f"{topic}/peers", event=f"unsubscribed {topic}/peers")
    node.wait_line("^called left$", 20)
    node.signal(signal.SIGINT)
    node.wait_line("^called hook$", 20)
    assert node.wait(60) == 0 and "over" in node.lines
    told = "\n".join(node.lines)
    for what in ("message", "service", "timer", "parameter", "joined", "left", "hook"):
        assert f"ValueError: bad {what}" in told, f"the log says what went wrong in {what}"


def test_callbacks_that_do_not_return(launcher: Master, topic: str) -> None:
    node, peer = start(launcher, BLOCKS, topic), launcher.ready_peer("roscpp", "peer")
    other = launcher.ready_peer("rospy", "other")
    for name in ("stuck", "good"):
        peer.advertise(f"{topic}/{name}", TEXT)
        peer.linked(f"{topic}/{name}")
    peer.publish(f"{topic}/stuck")
    other.tell("call", f"{topic}/stuck", FLIP, 1, 0)
    peer.ask("setparam", f"{topic}/param", "int", event=f"set {topic}/param")
    for what in ("message", "service", "timer", "parameter"):
        node.wait_line(f"^stuck {what}$", 20)
    for seed in range(3):
        peer.publish(f"{topic}/good", seed)
        node.wait_line("^good ", 20)
        peer.call(f"{topic}/flip", FLIP)
        node.wait_line("^tick$", 20)
    began = time.monotonic()
    node.signal(signal.SIGINT)
    node.wait(60)
    print(f"ended after {time.monotonic() - began:.1f} s")
    other.event("failed", f"{topic}/stuck", timeout=60)
