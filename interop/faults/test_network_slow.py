"""Links that are slow, and lose, delay and reorder packets."""

from __future__ import annotations

import json
import sys

from harness import STOCK_PYTHON
from site_of_two import IMAGE, TEXT, WAIT, Site, linked

SLOW = 10_000.0
"""Bytes per second."""
LARGE = 150_000
"""Bytes that take 15 s on such a link: longer than a call of the master may take that does not move."""
SET_BY_STOCK = "import rospy, sys; rospy.set_param('/by_stock', 'x' * int(sys.argv[1]))"
SET_BY_OURS = "import sys; from pyros1 import Node; Node('setter').params.set('/by_ours', 'x' * int(sys.argv[1]))"
GET_BY_OURS = "import sys; from pyros1 import Node; print(len(Node('getter').params.get(sys.argv[1])))"


def test_a_large_message_on_a_link_of_10_kb_per_second(site: Site) -> None:
    """It takes its time; meanwhile small topics arrive, parameters are read, and services are called."""
    uri = site.laptop.core("ours")
    big = site.robot.peer("pyros1", "big", uri)
    stock = site.robot.peer("rospy", "stock", uri)
    ours, roscpp = site.laptop.peer("pyros1", "ours", uri), site.laptop.peer("roscpp", "roscpp", uri)
    big.advertise("/image", IMAGE)
    big.advertise("/small_ours", TEXT)
    stock.advertise("/small_stock", TEXT)
    stock.serve("/service", "std_srvs/SetBool")
    ours.subscribe("/image", IMAGE)
    for topic, publisher in (("/small_ours", big), ("/small_stock", stock)):
        for each in (ours, roscpp):
            each.subscribe(topic, TEXT)
        linked(publisher, topic, 2)
    linked(big, "/image", 1)
    for path in site.wires.both_ways(site.robot, site.laptop):
        path.rate = SLOW
    image = big.publish("/image", LARGE)
    for seed in range(5):
        for topic, publisher in (("/small_ours", big), ("/small_stock", stock)):
            body = publisher.publish(topic, seed)
            for each in (ours, roscpp):
                assert each.received(topic, timeout=WAIT) == body
    ours.tell("call", "/service", "std_srvs/SetBool", 1, 0)
    ours.event("answer", "/service", timeout=WAIT)
    stock.ask("setparam", "/p", "int", event="set /p", timeout=WAIT)
    assert big.ask("getparam", "/p", timeout=WAIT) == "42"
    assert not ours.unread("^got /image"), "the link is not slow"
    assert ours.received("/image", timeout=WAIT) == image


def test_large_parameters_on_a_link_of_10_kb_per_second(site: Site) -> None:
    """They come through in both directions, at our master as at stock's."""
    for kind, port in (("ours", 11311), ("stock", 11312)):
        site.laptop.core(kind, port)
    for path in site.wires.both_ways(site.robot, site.laptop):
        path.rate = SLOW
    uris = [f"http://{site.laptop.address}:{port}/" for port in (11311, 11312)]
    ours, stock = [sys.executable, "-c"], [STOCK_PYTHON, "-c"]
    setting = [
        site.robot.start([*ours, SET_BY_OURS, str(LARGE)], site.robot.environ(uris[1]), "sets at stock's"),
        site.robot.start([*stock, SET_BY_STOCK, str(LARGE)], site.robot.environ(uris[0], "stock"), "sets at ours"),
    ]
    assert [each.wait(2 * WAIT) for each in setting] == [0, 0]
    getting = [
        site.robot.start([*ours, GET_BY_OURS, "/by_stock"], site.robot.environ(uris[0]), "gets from ours"),
        site.robot.start([*ours, GET_BY_OURS, "/by_ours"], site.robot.environ(uris[1]), "gets from stock's"),
    ]
    for each in getting:
        each.wait_line(f"^{LARGE}$", timeout=2 * WAIT)


def test_packets_that_are_lost_late_and_out_of_order(site: Site) -> None:
    """Every message arrives, once and in order; services and parameters work."""
    uri = site.laptop.core("ours")
    for path in site.wires.both_ways(site.robot, site.laptop):
        path.lost, path.delay, path.jitter = 0.05, 0.01, 0.02
    ours, stock = site.robot.peer("pyros1", "ours", uri), site.robot.peer("rospy", "stock", uri)
    roscpp, near = site.laptop.peer("roscpp", "roscpp", uri), site.laptop.peer("pyros1", "near", uri)
    stock.serve("/service", "std_srvs/SetBool")
    for publisher, topic, *subscribers in ((ours, "/from_ours", roscpp, near), (stock, "/from_stock", near)):
        publisher.advertise(topic, TEXT, queue_size=1000)
        for each in subscribers:
            each.subscribe(topic, TEXT, queue_size=1000)
        linked(publisher, topic, len(subscribers))
    sent = {
        topic: [each.publish(topic, seed) for seed in range(200)]
        for topic, each in (("/from_ours", ours), ("/from_stock", stock))
    }
    for each, topic in ((roscpp, "/from_ours"), (near, "/from_ours"), (near, "/from_stock")):
        assert [each.received(topic, timeout=WAIT) for _ in range(200)] == sent[topic]
    for seed in range(5):
        near.tell("call", "/service", "std_srvs/SetBool", seed, 0)
        near.event("answer", "/service", timeout=WAIT)
        near.ask("setparam", f"/p{seed}", "dict", event=f"set /p{seed}", timeout=WAIT)
        assert "a" in json.loads(ours.ask("getparam", f"/p{seed}", timeout=WAIT))
