"""Views and calls about bags."""

from __future__ import annotations

import io
import threading
import time
from array import array
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pyros1.bag
from pyros1.bag.format.records import make_bag_header
from pyros1.ground.timing import Time
from pyros1.msgs import load_message
from pyros1.node import Node
from pyros1.web import calls
from pyros1.web.robot import Robot
from pyros1.web.server.wire import Push, RequestError
from pyros1.web.views import view_class
from pyros1.web.views.view import View

from ...bag.made import old_messages
from ...bag.old_bags import old_bag

PATIENCE = 20.0
START = 1_700_000_000


class Shown:
    """A view, and its pushes with their bytes."""

    def __init__(self, robot: Robot, name: str, args: dict[str, Any]) -> None:
        self._woken = threading.Event()
        self._closed = False
        self.view: View = view_class(name)(robot, args, self._woken.set)

    def close(self) -> None:
        if not self._closed:
            self._closed = True
            self.view.close()

    def until(self, fits: Callable[[Any], bool] = lambda data: True) -> Push:
        deadline = time.monotonic() + PATIENCE
        seen = None
        while time.monotonic() < deadline:
            self._woken.clear()
            push = self.view.poll()
            if push is not None:
                seen = push
                if fits(push.data):
                    return push
            self._woken.wait(0.02 if self.view.polls_periodically else 0.5)
        raise AssertionError(f"not seen; the last was {seen!r:.2000}")


@pytest.fixture
def bags(tmp_path: Path) -> Path:
    """A folder with a bag: ten numbers a second on /value for 20 s, an event every 5 s on a name without a slash."""
    folder = tmp_path / "bags"
    folder.mkdir()
    write(folder / "run.bag")
    return folder


def write(path: Path, seconds: int = 20) -> None:
    number, text = load_message("std_msgs/Float64"), load_message("std_msgs/String")
    with pyros1.bag.open(path, "w", chunk_threshold=2_000) as bag:
        for index in range(seconds * 10 + 1):
            stamp = Time(START + index // 10, index % 10 * 100_000_000)
            spike = 1000.0 if index == 77 else 0.0
            bag.write("/value", number(index / 10 + spike), stamp)
            if index % 50 == 0:
                bag.write("event", text(f"event {index}"), stamp)


@pytest.fixture
def shelved(make_robot: Callable[..., Robot], bags: Path) -> Robot:
    return make_robot(bags=(str(bags),))


@pytest.fixture
def show(shelved: Robot) -> Iterator[Callable[..., Shown]]:
    opened: list[Shown] = []

    def open_view(name: str, of: Robot = shelved, **args: Any) -> Shown:
        opened.append(Shown(of, name, args))
        return opened[-1]

    yield open_view
    for shown in reversed(opened):
        shown.close()


@pytest.fixture
def run(show: Callable[..., Shown], bags: Path) -> str:
    """The path of the bag, which is open."""
    path = str(bags / "run.bag")
    show("bag_file", path=path).until(lambda data: "topics" in data)
    return path


def lines(push: Push) -> dict[tuple[int, int], list[tuple[float, float]]]:
    """Return the curves of a push: their points."""
    numbers = array("d", push.blob or b"")
    found, at = {}, 0
    for curve in push.data["curves"]:
        count = curve["count"]
        times, values = numbers[at : at + count], numbers[at + count : at + 2 * count]
        found[curve["id"], curve["part"]] = list(zip(times, values, strict=True))
        at += 2 * count
    return found


def test_what_is_in_a_bag(show: Callable[..., Shown], bags: Path) -> None:
    facts = show("bag_file", path=str(bags / "run.bag")).until().data
    assert (facts["length"], facts["messages"], facts["start"]) == (20.0, 206, float(START))
    assert [(each["name"], each["type"], each["count"]) for each in facts["topics"]] == [
        ("/value", "std_msgs/Float64", 201),
        ("event", "std_msgs/String", 5),
    ]
    assert facts["problems"] == [] and list(facts["storage"]) == ["none"]


def test_a_file_that_takes_the_place_of_an_open_bag_is_another_bag(
    show: Callable[..., Shown], shelved: Robot, bags: Path
) -> None:
    path = str(bags / "run.bag")
    first = show("bag_file", path=path)
    first.until()
    cursor = show("bag_cursor", path=path, time=3.0, topics=["event"])
    write(bags / "again.bag", 5)
    (bags / "again.bag").replace(path)
    with pytest.raises(RequestError, match="has been replaced"):
        shelved.bags.borrow(path)
    second = show("bag_file", path=path)
    assert second.until().data["length"] == 5.0
    assert cursor.until().data["messages"]["event"], "the old one is still read"
    cursor.close()
    first.close()
    second.close()
    with pytest.raises(RequestError, match="not open"):
        shelved.bags.borrow(path)


def test_pages_share_one_reader(show: Callable[..., Shown], shelved: Robot, bags: Path) -> None:
    path = str(bags / "run.bag")
    first, second = show("bag_file", path=path), show("bag_file", path=path)
    first.until()
    second.until()
    bag = shelved.bags.borrow(path)
    first.close()
    assert shelved.bags.borrow(path) is bag
    shelved.bags.release(bag)
    shelved.bags.release(bag)
    second.close()
    with pytest.raises(RequestError, match="not open"):
        shelved.bags.borrow(path)


@pytest.mark.parametrize(
    ("content", "words"),
    [(b"", "empty"), (b"not a bag at all", "not a bag"), (b"#ROSBAG V2.0\nrubbish" + bytes(100), "")],
)
def test_files_that_are_no_bags_say_so(show: Callable[..., Shown], bags: Path, content: bytes, words: str) -> None:
    (bags / "bad.bag").write_bytes(content)
    problem = show("bag_file", path=str(bags / "bad.bag")).until().data["problem"]
    assert "bad.bag" in problem and words in problem


def test_a_bag_that_was_not_closed_is_read_and_says_so(show: Callable[..., Shown], bags: Path) -> None:
    data = (bags / "run.bag").read_bytes()
    (bags / "cut.bag").write_bytes(data[: len(data) // 2])
    facts = show("bag_file", path=str(bags / "cut.bag")).until(lambda data: "topics" in data).data
    assert 50 < facts["messages"] < 206
    assert any("reindex" in problem for problem in facts["problems"])
    counts = show("bag_timeline", path=str(bags / "cut.bag"), begin=-1, end=21, columns=22, topics=["/value"]).until()
    assert 50 < sum(array("f", counts.blob or b"")) <= facts["messages"]


def test_an_old_bag_is_shown_and_says_so(show: Callable[..., Shown], bags: Path) -> None:
    path = str(bags / "old.bag")
    Path(path).write_bytes(old_bag(old_messages(12)))
    facts = show("bag_file", path=path).until(lambda data: "topics" in data).data
    assert facts["messages"] == 12 and any("1.2" in problem for problem in facts["problems"])
    counts = show("bag_timeline", path=path, begin=-0.005, end=0.115, columns=12, topics=["/a", "/b"]).until()
    assert np.frombuffer(counts.blob or b"", np.float32).reshape(2, 12).tolist() == [[1.0, 0.0] * 6, [0.0, 1.0] * 6]
    messages = show("bag_cursor", path=path, time=0.055, topics=["/a", "/b"]).until().data["messages"]
    assert messages["/a"]["value"]["fields"] == [["data", "int32", 4]]


def test_an_encrypted_bag_says_what_it_needs(show: Callable[..., Shown], bags: Path) -> None:
    path = bags / "run.bag"
    more = {"encryptor": b"rosbag/AesCbcEncryptor", "gpg_user": b"nobody", "encrypted_key": b"rubbish"}
    path.write_bytes(b"#ROSBAG V2.0\n" + make_bag_header(5_000, 0, 0, more) + bytes(2_000))
    assert "encrypted" in show("bag_file", path=str(path)).until().data["problem"]


def test_paths_outside_are_refused(show: Callable[..., Shown], bags: Path, tmp_path: Path) -> None:
    write(tmp_path / "secret.bag", 1)
    for path in (str(tmp_path / "secret.bag"), f"{bags}/../secret.bag"):
        with pytest.raises(RequestError, match="outside"):
            show("bag_file", path=path)


def test_topics_that_pages_may_not_see_are_not_there(make_robot: Callable[..., Robot], bags: Path) -> None:
    robot = make_robot(bags=(str(bags),), topics=("/event",))
    path = str(bags / "run.bag")
    shown = Shown(robot, "bag_file", {"path": path})
    assert [each["name"] for each in shown.until().data["topics"]] == ["event"]
    cursor = Shown(robot, "bag_cursor", {"path": path, "time": 5.0, "topics": ["/value", "event"]})
    assert list(cursor.until().data["messages"]) == ["event"]
    plot = Shown(robot, "bag_plot", {"path": path, "curves": [{"id": 1, "text": "/value/data"}]})
    assert plot.until(lambda data: data["progress"] == 1).data["problems"]
    for each in (plot, cursor, shown):
        each.close()


def test_where_messages_are(show: Callable[..., Shown], run: str) -> None:
    push = show(
        "bag_timeline", path=run, begin=-0.05, end=20.05, columns=201, topics=["/value", "event", "/no"]
    ).until()
    assert push.data["topics"] == ["/value", "event"] and push.data["exact"]
    counts = np.frombuffer(push.blob or b"", np.float32).reshape(2, 201)
    assert (counts[0] == 1).all()
    assert np.flatnonzero(counts[1]).tolist() == [0, 50, 100, 150, 200]


def test_the_messages_at_a_time(show: Callable[..., Shown], run: str) -> None:
    cursor = show("bag_cursor", path=run, time=7.25, topics=["/value", "event"])
    messages = cursor.until().data["messages"]
    assert messages["/value"]["value"]["fields"] == [["data", "float64", 7.2]]
    assert messages["event"]["value"]["fields"] == [["data", "string", "event 50"]]
    assert messages["event"]["time"] == 5.0
    assert cursor.view.poll() is None
    cursor.view.change({"path": run, "time": -1.0, "topics": ["/value"]})
    assert cursor.until().data["messages"] == {}


@pytest.mark.parametrize("time", [-5.0, -4.2e9, 4.2e9])
def test_times_far_from_a_bag(show: Callable[..., Shown], shelved: Robot, run: str, time: float) -> None:
    assert show("bag_cursor", path=run, time=time, topics=["/value"]).until().data["time"] == time
    begin, end = sorted((time, 1.0))
    counts = show("bag_timeline", path=run, begin=begin, end=end, columns=2, topics=["/value"]).until().blob
    assert np.frombuffer(counts or b"", np.float32).sum() > 0
    for forward in (True, False):
        calls.run(shelved, "bags.step", {"path": run, "time": time, "topics": ["/value"], "forward": forward})


def test_steps_from_message_to_message(shelved: Robot, run: str) -> None:
    def step(time: float, topics: list[str], forward: bool = True) -> Any:
        return calls.run(shelved, "bags.step", {"path": run, "time": time, "topics": topics, "forward": forward})

    assert step(0.0, ["event"]) == 5.0
    assert step(5.0, ["event", "/value"]) == 5.1
    assert step(5.0, ["event"], False) == 0.0
    assert step(0.0, ["event"], False) is None
    assert step(20.0, ["/value"]) is None
    assert step(3.0, []) is None


def test_recorded_numbers_keep_their_spikes(show: Callable[..., Shown], run: str) -> None:
    curves = [{"id": 1, "text": "/value/data"}, {"id": 2, "text": "/nothing/data"}, {"id": 3, "text": "/value/dat"}]
    plot = show("bag_plot", path=run, curves=curves, begin=0.0, end=20.0)
    push = plot.until(lambda data: data["progress"] == 1)
    points = lines(push)[1, -1]
    assert len(points) == 201
    assert points[77] == (7.7, 1007.7)
    assert "no such topic" in push.data["problems"][2] and "dat" in push.data["problems"][3]
    plot.view.change({"path": run, "curves": curves[:1], "begin": 5.0, "end": 6.0})
    push = plot.until(lambda data: data["progress"] == 1 and data["begin"] == 5.0)
    assert [time for time, _ in lines(push)[1, -1]] == pytest.approx([5 + index / 10 for index in range(11)])


def test_a_topic_without_a_slash_is_found_with_one(show: Callable[..., Shown], run: str) -> None:
    plot = show("bag_plot", path=run, curves=[{"id": 1, "text": "/event: len(m.data)"}])
    assert [value for _, value in lines(plot.until(lambda data: data["progress"] == 1))[1, -1]] == [7, 8, 9, 9, 9]


@pytest.mark.parametrize("name", ["event", "/event", "value", "/value"])
def test_views_find_topics_with_and_without_a_slash(
    show: Callable[..., Shown], shelved: Robot, run: str, name: str
) -> None:
    recorded = "event" if "event" in name else "/value"
    assert list(show("bag_cursor", path=run, time=5.0, topics=[name]).until().data["messages"]) == [recorded]
    timeline = {"path": run, "begin": 0.0, "end": 20.0, "columns": 4, "topics": [name]}
    assert show("bag_timeline", **timeline).until().data["topics"] == [recorded]
    step = {"path": run, "time": 0.0, "topics": [name], "forward": True}
    assert calls.run(shelved, "bags.step", step) == pytest.approx(5.0 if recorded == "event" else 0.1)


def test_pictures(show: Callable[..., Shown], bags: Path) -> None:
    pil = pytest.importorskip("PIL.Image")
    image, compressed = load_message("sensor_msgs/Image"), load_message("sensor_msgs/CompressedImage")
    red = np.zeros((120, 160, 3), np.uint8)
    red[:, :, 0] = 250
    file = io.BytesIO()
    pil.fromarray(red).save(file, "PNG")
    with pyros1.bag.open(bags / "camera.bag", "w") as bag:
        bag.write("/raw", image(height=120, width=160, encoding="rgb8", step=480, data=red.tobytes()), Time(START, 0))
        bag.write("/png", compressed(format="png", data=file.getvalue()), Time(START, 0))
        bag.write("/bad", compressed(format="jpeg", data=b"\xff\xd8nothing"), Time(START, 0))
        bag.write("/huge", image(height=1 << 20, width=1 << 20, encoding="rgb8", step=3, data=b""), Time(START, 0))
    path = str(bags / "camera.bag")
    assert all(each["image"] for each in show("bag_file", path=path).until().data["topics"])
    for topic in ("/raw", "/png"):
        pictures = show("bag_pictures", path=path, topic=topic, times=[0.0, -1.0], height=60)
        push = pictures.until()
        small = pil.open(io.BytesIO(push.blob or b""))
        assert small.size == (80, 60) and small.getpixel((40, 30))[0] > 200
        assert (push.data["width"], push.data["height"], push.data["time"]) == (160, 120, 0.0)
        assert pictures.until().blob == b""  # before the first one
        assert pictures.view.poll() is None
    for topic, words in (("/bad", "cannot be read: its format is unknown"), ("/huge", "too large")):
        push = show("bag_pictures", path=path, topic=topic, times=[0.0]).until()
        assert words in push.data["problem"] and push.blob == b""
    with pytest.raises(RequestError, match="no images"):
        show("bag_pictures", path=path, topic="/nothing", times=[0.0])


def test_playing_publishes_until_the_page_leaves(
    show: Callable[..., Shown], run: str, make_node: Callable[..., Node]
) -> None:
    got: list[float] = []
    come = threading.Condition()

    def poll(message: Any) -> None:
        with come:
            got.append(message.data)
            come.notify_all()

    def until(fits: Callable[[], bool]) -> None:
        with come:
            assert come.wait_for(fits, PATIENCE), got[-20:]

    make_node("listener").subscribe("/value", "std_msgs/Float64", poll)
    play = show("bag_play", path=run, rate=100.0, start=15.0, topics=["/value"])
    assert play.until(lambda status: status["state"] == "ended").data["time"] == 20.0
    until(lambda: bool(got) and got[-1] == 20.0)
    assert 15.0 <= got[0] < 20.0 and got == sorted(got)
    play.view.change({"path": run, "rate": 100.0, "start": 2.0, "topics": ["/value"]})  # back, while it is at the end
    until(lambda: 2.0 in got)
    play.view.change({"path": run, "rate": 1.0, "paused": True, "topics": ["/value"]})
    play.until(lambda status: status["state"] == "paused")
    play.close()
    assert not any(topic == "/value" for topic, _ in make_node("observer").master.get_published_topics())


class Listener:
    """What comes on /value."""

    def __init__(self, node: Node) -> None:
        self.got: list[float] = []
        self._come = threading.Condition()
        node.subscribe("/value", "std_msgs/Float64", self._take)

    def _take(self, message: Any) -> None:
        with self._come:
            self.got.append(message.data)
            self._come.notify_all()

    def until(self, fits: Callable[[list[float]], bool]) -> None:
        with self._come:
            assert self._come.wait_for(lambda: fits(self.got), PATIENCE), self.got[-20:]


def nothing_is_left(node: Node) -> bool:
    """Return whether nothing is published any more, and no thread plays."""
    topics = {topic for topic, _ in node.master.get_published_topics()}
    threads = {thread.name for thread in threading.enumerate()}
    return not topics & {"/value", "/event", "/clock"} and "web: playback" not in threads


@pytest.mark.parametrize("state", ["running", "paused", "ended"])
def test_playing_that_is_stopped_leaves_nothing_behind(
    show: Callable[..., Shown], shelved: Robot, run: str, make_node: Callable[..., Node], state: str
) -> None:
    node = make_node("listener")
    listener = Listener(node)
    rate, start = (100.0, 19.0) if state == "ended" else (1.0, 0.0)
    play = show("bag_play", path=run, rate=rate, start=start, clock=True)
    listener.until(bool)
    if state == "paused":
        play.view.change({"path": run, "rate": rate, "paused": True, "clock": True})
    play.until(lambda status: status["state"] == state)
    assert {"/value", "/event", "/clock"} <= {topic for topic, _ in node.master.get_published_topics()}
    play.close()
    assert nothing_is_left(node)
    bag = shelved.bags.borrow(run)  # it stays open for those who look at it
    shelved.bags.release(bag)


def test_a_loop_begins_again_until_it_is_no_loop(
    show: Callable[..., Shown], run: str, make_node: Callable[..., Node]
) -> None:
    node = make_node("listener")
    listener = Listener(node)
    options = {"path": run, "rate": 100.0, "topics": ["/value"]}
    play = show("bag_play", loop=True, **options)
    listener.until(lambda got: got.count(20.0) >= 3)
    again = [index for index, value in enumerate(listener.got[1:]) if value == 0.0]
    assert len(again) >= 2 and all(listener.got[index] == 20.0 for index in again)  # each turn to its end
    play.view.change({**options, "loop": False})
    play.until(lambda status: status["state"] == "ended")
    play.close()
    assert nothing_is_left(node)


def test_a_bag_that_breaks_while_it_is_played_says_so_and_can_be_played_again(
    show: Callable[..., Shown], bags: Path, make_node: Callable[..., Node]
) -> None:
    node = make_node("listener")
    listener = Listener(node)
    path = bags / "breaks.bag"
    write(path, 60)
    size = path.stat().st_size
    show("bag_file", path=str(path)).until(lambda data: "topics" in data)
    with open(path, "r+b") as file:  # the index was read; the messages in the middle are overwritten now
        file.seek(size // 3)
        good = file.read(size // 3)
        file.seek(size // 3)
        file.write(b"\xff" * len(good))
    options = {"path": str(path), "rate": 100.0, "topics": ["/value"]}
    play = show("bag_play", loop=True, **options)
    status = play.until(lambda status: status["state"] == "failed").data
    assert status["problem"] and 0 < status["time"] < 60.0
    listener.until(bool)
    with open(path, "r+b") as file:
        file.seek(size // 3)
        file.write(good)
    play.view.change({**options, "start": 0.0})
    assert play.until(lambda status: status["state"] == "ended").data["problem"] == ""
    listener.until(lambda got: got[-1] == 60.0)
    play.close()
    assert nothing_is_left(node)


def test_a_server_that_ends_while_it_plays_leaves_nothing_behind(
    make_robot: Callable[..., Robot], bags: Path, make_node: Callable[..., Node]
) -> None:
    node = make_node("listener")
    listener = Listener(node)
    robot = make_robot(bags=(str(bags),))
    path = str(bags / "run.bag")
    shown = [Shown(robot, "bag_file", {"path": path})]
    shown[0].until()
    shown.append(Shown(robot, "bag_play", {"path": path, "loop": True}))
    listener.until(bool)
    robot.close()
    for each in reversed(shown):
        each.close()
    assert nothing_is_left(node)


def test_the_clock_is_not_published_where_pages_may_not_see_it(make_robot: Callable[..., Robot], bags: Path) -> None:
    robot = make_robot(bags=(str(bags),), topics=("/value",))
    path = str(bags / "run.bag")
    shown = Shown(robot, "bag_file", {"path": path})
    shown.until()
    with pytest.raises(RequestError, match="--topics"):
        Shown(robot, "bag_play", {"path": path, "clock": True})
    play = Shown(robot, "bag_play", {"path": path, "paused": True})
    with pytest.raises(RequestError, match="--topics"):
        play.view.change({"path": path, "clock": True})
    play.close()
    shown.close()


def test_playing_is_refused_where_one_may_only_look(make_robot: Callable[..., Robot], bags: Path) -> None:
    robot = make_robot(bags=(str(bags),), read_only=True)
    path = str(bags / "run.bag")
    shown = Shown(robot, "bag_file", {"path": path})
    shown.until()
    with pytest.raises(RequestError, match="read-only"):
        Shown(robot, "bag_play", {"path": path})
    with pytest.raises(RequestError, match="read-only"):
        calls.run(robot, "bags.record", {"folder": str(bags), "topics": None})
    shown.close()


def test_recording(show: Callable[..., Shown], shelved: Robot, bags: Path, make_node: Callable[..., Node]) -> None:
    publisher: Any = make_node("talker").advertise("/counter", "std_msgs/Int32")
    status = show("bag_recording")
    calls.run(
        shelved, "bags.record", {"folder": str(bags), "prefix": "day", "topics": ["/counter"], "compression": "lz4"}
    )
    with pytest.raises(RequestError, match="running"):
        calls.run(shelved, "bags.record", {"folder": str(bags), "topics": None})
    assert publisher.wait_for_subscribers(timeout=PATIENCE)
    for number in range(50):
        publisher.publish(number)
    status.until(lambda data: data["recording"] and data["recording"]["messages"] == 50)
    done = calls.run(shelved, "bags.stop", {})
    assert not done["running"] and done["error"] == "" and done["bytes"] > 0
    path = Path(done["path"])
    assert path.parent == bags and path.name.startswith("day_")
    with pyros1.bag.open(path) as bag:
        assert [each.message.data for each in bag.messages("/counter")] == list(range(50))


def test_rates_of_a_recording_are_of_a_second_at_least(
    shelved: Robot, bags: Path, make_node: Callable[..., Node], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also if several pages look, one just after the other, and one topic comes later."""
    now = 100.0
    monkeypatch.setattr("pyros1.web.bags.recording.monotonic", lambda: now)
    publisher: Any = make_node("talker").advertise("/counter", "std_msgs/Int32")
    calls.run(shelved, "bags.record", {"folder": str(bags), "topics": ["/counter"]})
    recording = shelved.bags.recording
    assert recording is not None and publisher.wait_for_subscribers(timeout=PATIENCE)

    seen = []
    for count in range(1, 41):
        publisher.publish(count)
        deadline = time.monotonic() + PATIENCE
        while recording.status()["messages"] < count:  # at the time of the look before
            assert time.monotonic() < deadline
        now += 0.125
        seen.append(recording.status()["topics"][0]["hz"])
    assert {*seen} == {None, 8.0}
    assert recording.status()["topics"][0]["hz"] == 8.0  # again, at the same time
    calls.run(shelved, "bags.stop", {})


@pytest.mark.parametrize(
    ("args", "words"),
    [
        ({"prefix": "../x"}, "name may contain"),
        ({"prefix": ".x"}, "name may contain"),
        ({"prefix": "a/b"}, "name may contain"),
        ({"folder": "/"}, "outside"),
        ({"topics": []}, "choose a topic"),
        ({"compression": "zip"}, "compression"),
    ],
)
def test_wrong_recordings_are_refused(shelved: Robot, bags: Path, args: dict[str, Any], words: str) -> None:
    with pytest.raises(RequestError, match=words):
        calls.run(shelved, "bags.record", {"folder": str(bags), "topics": None, **args})
    assert shelved.bags.recording is None


def test_a_recording_ends_with_the_server(shelved: Robot, bags: Path) -> None:
    calls.run(shelved, "bags.record", {"folder": str(bags), "topics": ["/nothing"]})
    shelved.close()
    assert not list(bags.glob("*.active"))
    assert len(list(bags.glob("2*.bag"))) == 1
