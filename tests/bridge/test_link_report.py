"""What a bridge logs of its connections."""

from __future__ import annotations

from pyros1.bridge.exchange.actions import Log
from pyros1.bridge.link_report import PATIENCE, LinkReport
from pyros1.bridge.transport.connections import Connection
from pyros1.bridge.transport.link import Link

RED, GREEN = Connection("1", "red", "10.0.0.2:5"), Connection("2", "green", "10.0.0.3:5")


class FakeLink(Link):
    """A link whose connections the test sets."""

    def __init__(self) -> None:
        self.problem = ""
        self.open: list[Connection] = []

    def connections(self) -> list[Connection]:
        return self.open


def test_no_connection() -> None:
    link = FakeLink()
    report = LinkReport(link, ())
    assert report.update(0.0) == []
    link.problem = "refused"
    assert report.update(1.0) == [] and report.update(PATIENCE) == []
    assert report.update(1.0 + PATIENCE) == [Log("no connection to other sites: refused", is_warning=True)]
    assert report.update(100.0) == []
    link.problem = "no such host"
    assert report.update(101.0) == [Log("no connection to other sites: no such host", is_warning=True)]
    link.problem = ""
    assert report.update(102.0) == [Log("connected to other sites")] and report.update(103.0) == []


def test_what_it_connects_to() -> None:
    link = FakeLink()
    report = LinkReport(link, (), "ROS 2")
    link.problem = "refused"
    report.update(0.0)
    assert report.update(PATIENCE) == [Log("no connection to ROS 2: refused", is_warning=True)]
    link.problem = ""
    assert report.update(PATIENCE + 1) == [Log("connected to ROS 2")]


def test_a_short_wait_is_not_logged() -> None:
    link = FakeLink()
    report = LinkReport(link, ())
    for now, problem in ((0.0, "refused"), (PATIENCE - 1, ""), (PATIENCE, "refused"), (PATIENCE + 1, "")):
        link.problem = problem
        assert report.update(now) == []


def test_who_may_do_nothing() -> None:
    link = FakeLink()
    report = LinkReport(link, ["red"])
    link.open = [RED, GREEN]
    (log,) = report.update(0.0)
    assert log.is_warning and log.text.startswith("site green connected (10.0.0.3:5): it is not named under `sites`")
    link.open = [GREEN]
    assert report.update(1.0) == []
    link.open = []
    assert report.update(2.0) == []
