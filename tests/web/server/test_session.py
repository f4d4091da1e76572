"""Streams and calls of one page; time is an argument."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import pytest

from pyros1.web import views
from pyros1.web.robot import Robot
from pyros1.web.server import wire
from pyros1.web.server.session import MAX_STREAMS, Session
from pyros1.web.server.wire import Call, Change, Close, Next, Open, Push, RequestError
from pyros1.web.views.view import View


class Counter(View):
    """Shows how often it was looked at; the last ones that were made are in `made`."""

    period = 1.0
    made: list[Counter] = []

    def __init__(self, robot: Robot, args: Any, wake: Any) -> None:
        super().__init__(robot, args, wake)
        if args.get("fail"):
            raise RequestError("not yet")
        self.count = 0
        self.closed = False
        self.problem = ""
        Counter.made.append(self)
        wake()

    def poll(self) -> Push | None:
        if self.problem:
            raise RequestError(self.problem)
        self.count += 1
        return Push(self.count)

    def change(self, args: Any) -> None:
        self.count = args["count"]

    def close(self) -> None:
        self.closed = True


@pytest.fixture
def session(monkeypatch: pytest.MonkeyPatch) -> Session:
    Counter.made = []
    monkeypatch.setattr(views, "VIEW_NAMES", frozenset({"counter"}))
    monkeypatch.setattr(views, "view_class", lambda name: Counter)
    return Session(None, lambda: None)  # type: ignore[arg-type]  # these views need no robot


def poll(session: Session, now: float) -> tuple[list[str | bytes], float | None]:
    """Return the frames that are due at a time, and the time of the next ones."""
    numbers, again = session.take_due_streams(now)
    frames = [frame for number in numbers if (frame := session.push(number)) is not None]
    return frames, session.take_due_streams(now)[1] if numbers else again


def shown(frames: list[str | bytes]) -> list[Any]:
    return [json.loads(frame) for frame in frames]


def test_one_push_is_on_its_way_and_the_next_waits_for_the_page(session: Session) -> None:
    assert session.handle(Open(1, "counter", {})) == []
    frames, again = poll(session, 0.0)
    assert (shown(frames), again) == ([{"stream": 1, "data": 1}], None)
    Counter.made[0].wake()
    assert poll(session, 5.0) == ([], None)
    session.handle(Next(1))
    assert shown(poll(session, 6.0)[0]) == [{"stream": 1, "data": 2}]


def test_no_more_often_than_the_view_wants(session: Session) -> None:
    session.handle(Open(1, "counter", {}))
    poll(session, 0.0)
    session.handle(Next(1))
    Counter.made[0].wake()
    assert poll(session, 0.25) == ([], 1.0)
    assert len(poll(session, 1.0)[0]) == 1


def test_a_view_that_cannot_be_made_yet_is_tried_again_and_says_so_once(session: Session) -> None:
    session.handle(Open(1, "counter", {"fail": True}))
    frames, again = poll(session, 0.0)
    assert shown(frames) == [{"stream": 1, "error": "not yet"}]
    assert again == 1.0
    assert poll(session, 0.5) == ([], 1.0)
    assert poll(session, 1.0) == ([], 2.0)
    session.handle(Change(1, {}))
    assert shown(poll(session, 1.5)[0]) == [{"stream": 1, "data": 1}]


def test_a_problem_is_told_once_and_the_view_goes_on(session: Session) -> None:
    session.handle(Open(1, "counter", {}))
    poll(session, 0.0)
    view = Counter.made[0]
    session.handle(Next(1))
    view.problem = "broken"
    view.wake()
    assert shown(poll(session, 1.0)[0]) == [{"stream": 1, "error": "broken"}]
    view.wake()
    assert poll(session, 2.0)[0] == []
    view.problem = ""
    view.wake()
    assert shown(poll(session, 3.0)[0]) == [{"stream": 1, "data": 2}]


def test_a_fault_of_ours_is_told_and_the_view_goes_on(session: Session, monkeypatch: pytest.MonkeyPatch) -> None:
    session.handle(Open(1, "counter", {}))
    poll(session, 0.0)
    session.handle(Next(1))
    with monkeypatch.context() as patch:
        patch.setattr(Counter, "poll", lambda self: Push(float("nan")))
        Counter.made[0].wake()
        (frame,) = shown(poll(session, 1.0)[0])
        assert frame["stream"] == 1
        assert "internal server error" in frame["error"]
    Counter.made[0].wake()
    assert shown(poll(session, 2.0)[0]) == [{"stream": 1, "data": 2}]


def test_a_slow_view_delays_no_other_one(session: Session) -> None:
    for number in (1, 2):
        session.handle(Open(number, "counter", {}))
    poll(session, 0.0)
    for number in (1, 2):
        session.handle(Next(number))
        Counter.made[number - 1].wake()
    assert session.take_due_streams(1.0) == ([1, 2], None)
    Counter.made[1].wake()
    assert session.take_due_streams(5.0) == ([], None)  # both are under way
    assert session.push(2) is not None
    session.handle(Next(2))
    Counter.made[1].wake()
    assert session.take_due_streams(6.0) == ([2], None)  # and the first still is


def test_what_is_closed_while_it_is_due_says_nothing(session: Session) -> None:
    session.handle(Open(1, "counter", {}))
    assert session.take_due_streams(0.0) == ([1], None)
    session.handle(Close(1))
    assert session.push(1) is None
    assert Counter.made == []


def test_change_and_close(session: Session) -> None:
    session.handle(Open(1, "counter", {}))
    poll(session, 0.0)
    session.handle(Next(1))
    session.handle(Change(1, {"count": 41}))
    assert shown(poll(session, 0.1)[0]) == [{"stream": 1, "data": 42}]
    session.handle(Close(1))
    assert Counter.made[0].closed
    for request in (Next(1), Change(1, {}), Close(1)):
        assert session.handle(request) == []  # it may have crossed our last push
    assert poll(session, 9.0) == ([], None)


def test_wrong_requests_are_answered(session: Session) -> None:
    session.handle(Open(1, "counter", {}))
    assert "is already open" in shown(session.handle(Open(1, "counter", {})))[0]["error"]  # type: ignore[arg-type]
    assert "unknown view" in shown(session.handle(Open(2, "nothing", {})))[0]["error"]  # type: ignore[arg-type]
    for number in range(2, MAX_STREAMS + 1):
        session.handle(Open(number, "counter", {}))
    assert "at most" in shown(session.handle(Open(999, "counter", {})))[0]["error"]  # type: ignore[arg-type]
    session.close()
    poll(session, 0.0)
    assert all(view.closed for view in Counter.made)


def test_calls(robot: Robot, make_node: Callable[..., Any]) -> None:
    session = Session(robot, lambda: None)

    def ask(call: str, **args: Any) -> Any:
        answer = json.loads(session.run_call(Call(5, call, args)))
        assert answer.pop("id") == 5
        return answer.get("result", answer)

    assert "unknown call" in ask("nothing")["error"]
    assert "unknown call" in ask("topics.nothing")["error"]
    assert "unknown call" in ask("page.__dict__")["error"]
    assert ask("params.put", name="/a/b", yaml="[1, 2.5, x]") is None
    assert ask("params.tree")["/a/b"] == [1, 2.5, "x"]
    assert ask("params.delete", name="/a") is None
    assert "/a/b" not in ask("params.tree")
    assert "error" in ask("params.put", name="/a", yaml="[1")
    received: list[float] = []
    node = make_node("listener")
    node.subscribe("topic1", "std_msgs/Float64", lambda message: received.append(message.data))
    node.advertise_service("twice", "rospy_tutorials/AddTwoInts", lambda request: 2 * request.a)
    assert ask("topics.publish", topic="/topic1", type="std_msgs/Float64", value={"data": 1.5}) == {"subscribers": 1}
    assert "error" in ask("topics.publish", topic="/topic1", type="std_msgs/Float64", value={"dat": 1.5})
    assert "error" in ask("topics.publish", topic="/topic1", type="no_msgs/Type", value={})
    assert ask("topics.form", topic="/topic1")["fields"] == [["data", "float64", None, None]]
    assert "/topic1/data" in ask("topics.fields", begin="/top")
    assert ask("services.form", service="/twice")["type"] == "rospy_tutorials/AddTwoInts"
    assert ask("services.call", service="/twice", value={"a": 21})["value"] == {"fields": [["sum", "int64", 42]]}
    assert "no node provides" in ask("services.call", service="/nothing", value={})["error"]
    facts = ask("nodes.info", node="/listener")
    assert "/twice" in facts["services"]
    assert "there is no node" in ask("nodes.info", node="/nobody")["error"]
    assert ["rosout", "info"] in ask("nodes.loggers", node="/listener")
    assert ask("nodes.set_level", node="/listener", logger="rosout", level="debug") is None
    assert ["rosout", "debug"] in ask("nodes.loggers", node="/listener")
    assert ask("nodes.kill", node="/listener") is None
    node.spin()  # it ends at once, or soon
    assert not node.ok()


@pytest.mark.parametrize("name", ["system", "console", "plot", "message"])
def test_every_view_there_is_can_be_found(name: str) -> None:
    assert issubclass(views.view_class(name), View)
    assert isinstance(wire.Push(1).data, int)


def test_only_the_first_of_many_updates_wakes(monkeypatch: pytest.MonkeyPatch) -> None:
    """The push at the known time shows the newest; each waking costs more than most messages."""
    monkeypatch.setattr(views, "VIEW_NAMES", frozenset({"counter"}))
    monkeypatch.setattr(views, "view_class", lambda name: Counter)
    Counter.made = []
    woken: list[None] = []
    session = Session(None, lambda: woken.append(None))  # type: ignore[arg-type]  # these views need no robot
    session.handle(Open(1, "counter", {}))
    for now in (0.0, 1.0, 2.0):
        assert poll(session, now)[0]
        session.handle(Next(1))
        woken.clear()
        for _ in range(5):
            Counter.made[0].wake()
        assert len(woken) == (0 if now == 0.0 else 1)  # it wakes when it is made, too
