"""Nodes of ours and of stock on several hosts: who is reached, and what is said of those who are not.

All combinations of addresses: `combinations.py`, run by hand, makes the table in interop/hosts.md.

Feature: our nodes and stock's on several hosts -- three hosts, IPv6, NAT, an unplugged cable
"""

from __future__ import annotations

import sys
from typing import Any

from harness import until
from hosts import Network
from mixed import STRING, check_served, peers, provide


def test_three_hosts() -> None:
    """Master, publishers and subscribers on a host each; one is known by its address alone."""
    with Network() as network:
        robot, nuc, laptop = (network.add(name) for name in ("robot", "nuc", "laptop"))
        for host in (robot, laptop):
            host.forget("nuc")
        uri = robot.core("stock")
        talkers = peers(nuc, uri, "talker", ROS_IP=nuc.address)
        provide(talkers)
        listeners = peers(laptop, uri, "listener")
        for listener in listeners:
            check_served(listener)
        listeners[2].ask("setparam", "/speed", "int", event="set /speed")
        assert talkers[0].ask("hasparam", "/speed") == "1"
        # A publisher that comes later: the master tells the subscribers.
        late = robot.peer("roscpp", "late", uri)
        for listener in listeners:
            listener.subscribe("/late", STRING)
        late.advertise("/late", STRING, latch=True)
        late.publish("/late")
        for listener in listeners:
            listener.received("/late", timeout=40)


def test_ipv6() -> None:
    """ROS_IPV6=on, with names that have no other addresses."""
    with Network() as network:
        robot, laptop = network.add("robot"), network.add("laptop")
        for host in (robot, laptop):
            host.know({"robot": robot.address6, "laptop": laptop.address6})
        uri = robot.core("ours", 11311, ROS_IPV6="on")
        provide(peers(robot, uri, "talker", ROS_IPV6="on"))
        for listener in peers(laptop, uri, "listener", ROS_IPV6="on"):
            check_served(listener)
        numeric = f"http://[{robot.address6}]:11311/"
        own = {"ROS_IPV6": "on", "ROS_IP": laptop.address6}
        check_served(laptop.peer("pyros1", "numeric", numeric, **own))
        listed = laptop.run(laptop.pyros1("node", "info", "/numeric"), laptop.environ(numeric, **own)).output
        assert f"contacting node http://[{laptop.address6}]:" in listed and "Pid:" in listed


def test_one_way_through_a_router() -> None:
    """A host behind NAT hears those outside; those outside are told why they do not hear it."""
    with Network() as network:
        robot, laptop = network.add("robot"), network.add("laptop", behind_nat=True)
        uri = robot.core()
        provide([robot.peer("roscpp", "talker", uri), robot.peer("rospy", "other", uri)])
        inside, outside = laptop.peer("pyros1", "inside", uri), robot.peer("pyros1", "outside", uri)
        for kind in ("roscpp", "rospy"):
            inside.subscribe(f"/t_{kind}", STRING)
            inside.received(f"/t_{kind}", timeout=40)
            inside.call(f"/s_{kind}", "std_srvs/SetBool")
        inside.advertise("/inside", STRING, latch=True)
        outside.subscribe("/inside", STRING)
        outside.wait_line(r"no messages of /inside .*laptop.*export ROS_IP.*PYROS1_PORTS", timeout=60)


def test_a_firewall_that_lets_only_a_range_of_ports_through() -> None:
    """Ours can be told which ports to use, also for datagrams; stock's nodes need no more than that to reach them.

    Feature: nodes behind a firewall that allows only some ports -- `PYROS1_PORTS`, also for UDP
    """
    with Network() as network:
        robot, laptop = network.add("robot"), network.add("laptop")
        robot.firewall("tcp dport 11311 accept", "tcp dport 40000-40009 accept", "udp dport 40000-40009 accept")
        uri = robot.core("ours", 11311, "--ports", "40000-40009")
        talker = robot.peer("pyros1", "talker", uri, "__ports:=40000-40009")
        provide([talker])
        stranger = robot.peer("roscpp", "stranger", uri)
        stranger.advertise("/t_stranger", STRING, latch=True)
        listeners = peers(laptop, uri, "listener")
        for listener in listeners:
            listener.subscribe("/t_pyros1", STRING)
            listener.received("/t_pyros1", timeout=40)
            listener.call("/s_pyros1", "std_srvs/SetBool")
        back = laptop.peer("roscpp", "back", uri)
        back.advertise("/back", STRING, latch=True)
        back.publish("/back")
        talker.subscribe("/back", STRING)
        talker.received("/back", timeout=40)
        datagrams = (
            "import pyros1\n"
            "node = pyros1.Node('datagrams')\n"
            "node.subscribe('/back', 'std_msgs/String', lambda _: print('got', flush=True), transports='udp')\n"
            "node.spin()\n"
        )
        environ = robot.environ(uri, PYROS1_PORTS="40000-40009")
        robot.start([sys.executable, "-c", datagrams], environ, "datagrams").wait_line("^got", timeout=40)
        ours = listeners[2]
        ours.subscribe("/t_stranger", STRING)
        ours.wait_line(r"no messages of /t_stranger .*Connection refused.*a firewall rejects the port", timeout=60)


def test_wrong_addresses_are_named_with_the_cure() -> None:
    """In the subscriber's log, by calls and commands; for a subscriber that is wrong, in the core's terminal.

    Feature: errors name an unreachable address, and say what to set where -- in logs, call errors, `topic
        echo`, `node info`, `wtf`, and the core's terminal
    """
    wrong: dict[str, tuple[dict[str, str], str]] = {
        "localhost": ({"ROS_HOSTNAME": "localhost"}, r"localhost:\d+: Connection refused.*unset ROS_HOSTNAME.*ROS_IP"),
        "unknown": ({"ROS_HOSTNAME": "nobody"}, r"host name 'nobody' cannot be resolved here.*ROS_IP.*/etc/hosts"),
        "absent": ({"ROS_IP": "10.88.0.99"}, r"http://10\.88\.0\.99:.*export ROS_IP=<its address> and restart"),
    }
    with Network() as network:
        robot, laptop = network.add("robot"), network.add("laptop")
        core = robot.start(robot.pyros1("core"), robot.environ("http://robot:11311"), "core")
        uri = "http://robot:11311/"
        robot.await_port(11311)
        listener, deaf = laptop.peer("pyros1", "listener", uri), laptop.peer("roscpp", "deaf", uri, ROS_IP="10.88.0.98")
        deaf.subscribe("/t_localhost", STRING)
        for name, (extra, _) in wrong.items():
            talker = robot.peer("roscpp" if name == "absent" else "pyros1", name, uri, **extra)
            talker.advertise(f"/t_{name}", STRING, latch=True)
            talker.serve(f"/s_{name}", "std_srvs/SetBool")
            listener.subscribe(f"/t_{name}", STRING)
        core.wait_line(
            r"WARNING: /deaf cannot be notified of the publishers of /t_localhost: .*10\.88\.0\.98", timeout=60
        )
        for name, (_, pattern) in wrong.items():
            listener.wait_line(rf"no messages of /t_{name} .*{pattern}", timeout=60)
            listener.tell("call", f"/s_{name}", "std_srvs/SetBool", 1, 0)
            failed = listener.event("failed", f"/s_{name}", timeout=40)
            assert "ROS_IP" in failed, failed
        info = laptop.run(laptop.pyros1("node", "info", "/localhost"), laptop.environ(uri))
        assert info.code == 1 and "Connection refused" in info.output and "unset ROS_HOSTNAME" in info.output
        found = laptop.run(laptop.pyros1("wtf"), laptop.environ(uri)).output
        for words in ("[nobody]", "Nodes at [10.88.0.99] do not answer", "/localhost (http://localhost:"):
            assert words in found, found


def test_a_host_that_is_cut_off_comes_back() -> None:
    """The plug is pulled while messages flow, and put in again: the same subscribers go on."""
    with Network() as network:
        robot, laptop = network.add("robot"), network.add("laptop")
        uri = robot.core()
        talker, listener = robot.peer("roscpp", "talker", uri), laptop.peer("pyros1", "listener", uri)
        talker.advertise("/t", STRING)
        listener.subscribe("/t", STRING)
        talker.linked("/t")
        talker.publish("/t")
        listener.received("/t")
        network.cut(laptop)
        talker.publish("/t", 2)
        network.mend(laptop)

        def arrives() -> Any:
            talker.publish("/t", 3)
            return listener.unread("^got /t")

        until(arrives, "messages flow again", timeout=60)
