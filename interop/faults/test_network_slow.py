"""Links that are slow, and lose, delay and reorder packets.

Feature: large messages and parameters on a 10 kB/s link -- everything else keeps working meanwhile
"""

from __future__ import annotations

import json
import sys

from site_of_two import IMAGE, TEXT, WAIT, Site, linked

SLOW = 10_000.0
"""Bytes per second."""
LARGE = 120_000
"""Bytes that take 12 s on such a link: longer than a call of the master may stand still."""
SET = "import sys; from pyros1 import Node; Node('setter').params.set('/large', 'x' * int(sys.argv[1]))"
GET = "from pyros1 import Node; print(len(Node('getter').params.get('/large')))"


def test_a_link_of_10_kb_per_second(site: Site) -> None:
    """A large message and a large parameter take their time; small topics, services and parameters go on meanwhile."""
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
    done = site.laptop.run([sys.executable, "-c", SET, str(LARGE)], site.laptop.environ(uri))
    assert done.code == 0, done.output

    for path in site.wires.both_ways(site.robot, site.laptop):
        path.rate = SLOW
    image = big.publish("/image", LARGE)
    getting = site.robot.start([sys.executable, "-c", GET], site.robot.environ(uri), "gets a large parameter")
    for seed in range(3):
        for topic, publisher in (("/small_ours", big), ("/small_stock", stock)):
            body = publisher.publish(topic, seed)
            for each in (ours, roscpp):
                assert each.received(topic, timeout=WAIT) == body
        if not seed:
            assert not ours.unread("^got /image"), "the link is not slow"
    ours.tell("call", "/service", "std_srvs/SetBool", 1, 0)
    ours.event("answer", "/service", timeout=WAIT)
    stock.ask("setparam", "/p", "int", event="set /p", timeout=WAIT)
    assert big.ask("getparam", "/p", timeout=WAIT) == "42"
    assert ours.received("/image", timeout=WAIT) == image
    getting.wait_line(f"^{LARGE}$", timeout=WAIT)


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
