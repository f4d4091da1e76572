"""A name server that is silent for 30 s: what needs it waits in a bounded time, and all else goes on. A name that is
unknown at first is looked up again."""

from __future__ import annotations

import sys
from time import monotonic

import pytest
from hosts import Host
from site_of_two import TEXT, WAIT, Site, linked

SILENT = "nameserver 10.88.0.99\noptions timeout:15 attempts:2\n"
"""Nobody is at that address, and nobody says so."""
CALL = """
from pyros1 import Node
from pyros1.msgs.std_srvs.srv import SetBool, SetBoolRequest
with Node('caller') as node:
    for attempt in (lambda: node.service('/ghost', SetBool).call(SetBoolRequest(), timeout=1),
                    lambda: node.wait_for_service('/ghost', timeout=1)):
        try:
            attempt()
        except Exception as error:
            print(type(error).__name__, error, flush=True)
"""


@pytest.fixture
def laptop(site: Site) -> Host:
    """The laptop, which can resolve no name that is not in /etc/hosts."""
    (site.laptop.home / "resolv.conf").write_text(SILENT)
    return site.laptop


def register(host: Host, uri: str, method: str, *arguments: str) -> None:
    """Call the master as the node /ghost, from *host*."""
    call = f"import xmlrpc.client; print(xmlrpc.client.ServerProxy({uri!r}).{method}('/ghost', *{arguments!r}))"
    done = host.run([sys.executable, "-c", call])
    assert done.code == 0 and done.output.startswith("[1"), done.output


def test_topics_go_on(site: Site, laptop: Host) -> None:
    """One publisher of our subscriber is at a name without an answer, as is one subscriber of the master's notices."""
    uri = laptop.core("ours")
    for topic in ("/t", "/other"):
        register(laptop, uri, "registerPublisher", topic, TEXT, "http://ghost:12345/")
    register(laptop, uri, "registerSubscriber", "/t", TEXT, "http://phantom:12345/")
    ours = laptop.peer("pyros1", "ours", uri)
    for topic in ("/t", "/other"):
        ours.subscribe(topic, TEXT)
    for kind in ("roscpp", "rospy"):
        publisher = site.robot.peer(kind, f"far_{kind}", uri)
        publisher.advertise("/t", TEXT)
        linked(publisher, "/t", 1)
        body = publisher.publish("/t")
        assert ours.received("/t", timeout=WAIT) == body
    assert ours.quit() == 0


def test_a_name_that_is_unknown_at_first(site: Site) -> None:
    """The subscriber says so, and is linked when the name has an address."""
    uri = site.laptop.core("ours")
    talker = site.robot.peer("pyros1", "talker", uri, ROS_HOSTNAME="late")
    talker.advertise("/t", TEXT)
    ours = site.laptop.peer("pyros1", "ours", uri)
    ours.subscribe("/t", TEXT)
    ours.wait_line(r"no messages of /t .*host name 'late' cannot be resolved here.*ADDRESS late", timeout=WAIT)
    site.laptop.know({"late": site.robot.address})
    linked(talker, "/t", 1)
    body = talker.publish("/t")
    assert ours.received("/t", timeout=WAIT) == body


def test_services(laptop: Host) -> None:
    """A call, and a wait, end at their time limits."""
    uri = laptop.core("ours")
    register(laptop, uri, "registerService", "/ghost", "rosrpc://ghost:12345", "http://ghost:12346/")
    began = monotonic()
    program = laptop.start([sys.executable, "-c", CALL], laptop.environ(uri), "caller")
    program.wait_line("^WaitTimeoutError .*/ghost", timeout=WAIT)
    program.wait_line("^WaitTimeoutError .*/ghost", timeout=WAIT)
    assert program.wait(WAIT) == 0
    assert monotonic() - began < 30, "it has waited for the name server"


def test_the_master(laptop: Host) -> None:
    """The error says which name cannot be resolved, after the time that the call may take."""
    began = monotonic()
    done = laptop.run(laptop.pyros1("param", "get", "/p"), laptop.environ("http://ghost:11311/"))
    assert done.code != 0 and "'ghost' cannot be resolved here: no answer from the name server" in done.output
    assert "Traceback" not in done.output
    assert monotonic() - began < 30, "it has waited for the name server"
