"""The buffer: lookups, time, waiting. That the numbers are tf2's is shown by interop/tf/test_tf_buffer.py."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest

from pyros1.ground.errors import NodeShutdownError
from pyros1.ground.timing import Duration, Time
from pyros1.msgs import load_message
from pyros1.tf import (
    Buffer,
    ConnectivityException,
    ExtrapolationException,
    InvalidArgumentException,
    LookupException,
    TransformException,
)
from pyros1.tf.transformations import euler_from_quaternion, quaternion_from_euler

HALF_TURN = (0.0, 0.0, 1.0, 0.0)


def stamped(parent: str, child: str, seconds: float, x: float = 0.0, rotation: Any = (0, 0, 0, 1)) -> Any:
    message: Any = load_message("geometry_msgs/TransformStamped")()
    message.header.frame_id = parent
    message.header.stamp = Time.from_sec(seconds)
    message.child_frame_id = child
    message.transform.translation.x = x
    q = message.transform.rotation
    q.x, q.y, q.z, q.w = rotation
    return message


def x_of(message: Any) -> float:
    x: float = message.transform.translation.x
    return x


class Counted(threading.Condition):
    """A condition that knows how many threads wait for it."""

    def __init__(self) -> None:
        self.lock = threading.RLock()
        super().__init__(self.lock)
        self.waiting = 0

    def wait(self, timeout: float | None = None) -> bool:
        self.waiting += 1
        try:
            return super().wait(timeout)
        finally:
            self.waiting -= 1


@pytest.fixture
def changed() -> Counted:
    """What threads wait for that look for transforms in the buffer."""
    return Counted()


@pytest.fixture
def buffer(changed: Counted, monkeypatch: pytest.MonkeyPatch) -> Buffer:
    """map -> odom (moves 1 m a second) -> base (turned) -> lidar (static); and an island."""
    with monkeypatch.context() as patch:
        patch.setattr(
            "pyros1.tf.buffer.threading", SimpleNamespace(RLock=lambda: changed.lock, Condition=lambda _: changed)
        )
        result = Buffer()
    for second in (100, 101, 102):
        result.set_transform(stamped("map", "odom", second, x=second - 100), "/a")
    result.set_transform(stamped("odom", "base", 101, 1.0, HALF_TURN), "/b")
    result.set_transform(stamped("odom", "base", 101.5, 1.0, HALF_TURN), "/b")
    result.set_transform_static(stamped("base", "lidar", 0, 0.5), "/c")
    result.set_transform(stamped("isle", "palm", 101), "/d")
    return result


def test_numbers_in_answers_are_floats() -> None:
    buffer = Buffer()
    buffer.set_transform(stamped("map", "odom", 1, x=3))
    transform = buffer.lookup_transform("map", "odom").transform
    assert repr((transform.translation.x, transform.rotation.w)) == "(3.0, 1.0)"


def test_the_latest_common_time_is_the_default(buffer: Buffer) -> None:
    found = buffer.lookup_transform("map", "lidar")
    assert (found.header.frame_id, found.child_frame_id) == ("map", "lidar")
    assert found.header.stamp == Time.from_sec(101.5)
    assert x_of(found) == pytest.approx(1.5 + 1.0 - 0.5), "base looks back: the lidar is behind"
    assert buffer.get_latest_common_time("map", "lidar") == Time.from_sec(101.5)
    assert x_of(buffer.lookup_transform("lidar", "map")) == pytest.approx(2.0)
    assert buffer.lookup_transform("base", "lidar").header.stamp == Time(), "static: at all times"
    assert buffer.lookup_transform("odom", "odom").header.stamp == Time.from_sec(102)


@pytest.mark.parametrize("when", [101.25, Time.from_sec(101.25)])
def test_between_two_transforms_it_interpolates(buffer: Buffer, when: Any) -> None:
    assert x_of(buffer.lookup_transform("map", "odom", when)) == pytest.approx(1.25)
    turning = Buffer()
    turning.set_transform(stamped("a", "b", 1, rotation=quaternion_from_euler(0, 0, 0)))
    turning.set_transform(stamped("a", "b", 3, rotation=quaternion_from_euler(0, 0, 1.0)))
    q = turning.lookup_transform("a", "b", 2.5).transform.rotation
    assert euler_from_quaternion([q.x, q.y, q.z, q.w])[2] == pytest.approx(0.75)


def test_time_travel(buffer: Buffer) -> None:
    """Where odom was at 100.5, seen from odom at 102: it has moved 1.5 m since."""
    assert x_of(buffer.lookup_transform_full("odom", 102, "odom", 100.5, "map")) == pytest.approx(-1.5)
    assert buffer.can_transform_full("odom", 102, "odom", 100.5, "map")
    assert not buffer.can_transform_full("odom", 102, "odom", 100.5, "isle")
    assert "odom" in (buffer.why_not_full("odom", 102, "odom", 9, "map") or "")


@pytest.mark.parametrize(
    ("arguments", "error", "text"),
    [
        (("map", "nope"), LookupException, '"nope" passed to lookupTransform argument source_frame does not exist. '),
        (("map", "palm"), ConnectivityException, "Could not find a connection between 'map' and 'palm'"),
        (("map", "odom", 103), ExtrapolationException, "extrapolation 1.000000000s into the future"),
        (("map", "odom", 99.5), ExtrapolationException, "extrapolation 0.500000000s into the past"),
        (("isle", "palm", 1), ExtrapolationException, "but only time 101.000000000 is in the buffer"),
        (("/map", "odom"), InvalidArgumentException, "cannot start with a '/'"),
        (("map", ""), InvalidArgumentException, "cannot be empty"),
    ],
)
def test_errors(buffer: Buffer, arguments: Any, error: type[TransformException], text: str) -> None:
    with pytest.raises(error) as caught:
        buffer.lookup_transform(*arguments)
    assert text in str(caught.value)
    assert not buffer.can_transform(*arguments)
    assert buffer.why_not(*arguments)


def test_old_data_goes_and_older_is_refused() -> None:
    said: list[str] = []
    buffer = Buffer(Duration(2), warn=said.append)
    for second in range(10, 2010):
        buffer.set_transform(stamped("a", "b", second, float(second)))
    assert buffer.can_transform("a", "b", 2007) and not buffer.can_transform("a", "b", 2006.9)
    buffer.set_transform(stamped("a", "b", 2008.5, 0.0))
    assert x_of(buffer.lookup_transform("a", "b", 2008.75)) == pytest.approx(2009 / 2)
    assert not said
    for _ in range(100):
        buffer.set_transform(stamped("a", "b", 2006.9, 5.0), "/late")
        buffer.set_transform(stamped("a", "b", 2009, 5.0), "/again")
    assert x_of(buffer.lookup_transform("a", "b", 2009)) == 2009
    assert [text.split(" ", 1)[0] for text in said] == ["TF_OLD_DATA", "TF_REPEATED_DATA"] * 3
    assert [text.rpartition(" according to authority ")[2] for text in said] == [
        *("/late", "/again"),
        *("/late (10 times)", "/again (10 times)"),
        *("/late (100 times)", "/again (100 times)"),
    ]


def test_clear_keeps_static_transforms(buffer: Buffer) -> None:
    buffer.clear()
    assert buffer.can_transform("base", "lidar") and not buffer.can_transform("map", "odom")
    assert buffer.has_frame("map") and "palm" in buffer.frames()


def test_what_is_wrong_is_ignored_and_said(capsys: pytest.CaptureFixture[str]) -> None:
    buffer = Buffer()
    buffer.set_transform(stamped("/a", "/b", 1, math.nan))
    buffer.set_transform(stamped("a", "b", 1, 0.0, (0, 0, 0, 1.1)))
    assert not buffer.has_frame("b")
    err = capsys.readouterr().err
    assert "Error:   TF_NAN_INPUT" in err and "Error:   TF_DENORMALIZED_QUATERNION" in err
    buffer.set_transform(stamped("/a", "/b", 1))
    assert buffer.frames() == ["b", "a"], "leading slashes are taken away"


def test_texts_about_all_frames(buffer: Buffer) -> None:
    assert Buffer().all_frames_as_yaml() == "{}"
    assert "Frame lidar exists with parent base.\n" in buffer.all_frames_as_string()
    assert "odom: \n  parent: 'map'\n  broadcaster: '/a'\n  rate: 1.500\n" in buffer.all_frames_as_yaml()
    assert "  transform_delay: 8.000\n" in buffer.all_frames_as_yaml(now=110.0)
    assert buffer.chain("map", "lidar") == ["lidar", "base", "odom", "map"]
    assert buffer.chain("lidar", "map") == ["map", "odom", "base", "lidar"]
    buffer.set_transform(stamped("map", "other", 101))
    assert buffer.chain("other", "base", 101) == ["base", "odom", "map", "other"]


def test_a_loop_is_an_error() -> None:
    buffer = Buffer()
    for parent, child in ("ab", "bc", "ca"):
        buffer.set_transform(stamped(parent, child, 1))
    buffer.set_transform(stamped("a", "d", 1))
    buffer.set_transform(stamped("x", "y", 1))
    for when in (0, 1):
        with pytest.raises(LookupException, match="contains a loop"):
            buffer.lookup_transform("x", "d", when)


# Waiting --------------------------------------------------------------------------------------------------------------


def in_thread(call: Callable[[], Any]) -> tuple[threading.Thread, list[Any]]:
    results: list[Any] = []

    def run() -> None:
        try:
            results.append(call())
        except Exception as error:  # noqa: BLE001 - shown by the test
            results.append(error)

    thread = threading.Thread(target=run)
    thread.start()
    return thread, results


def await_waiting(changed: Counted, count: int = 1) -> None:
    """Until so many threads wait in the buffer."""
    met = threading.Event()
    for _ in range(10_000):
        if changed.waiting >= count:
            return
        met.wait(0.001)
    raise AssertionError("nobody waits")


def test_a_lookup_waits_for_what_comes(buffer: Buffer, changed: Counted) -> None:
    first, found = in_thread(lambda: buffer.lookup_transform("map", "new", 50, timeout=30))
    second, can = in_thread(lambda: buffer.can_transform("map", "new", 50, timeout=Duration(30)))
    third, full = in_thread(lambda: buffer.lookup_transform_full("map", 50, "new", 50, "map", timeout=30))
    await_waiting(changed, 3)
    buffer.set_transform(stamped("island", "elsewhere", 1))
    await_waiting(changed, 3)
    buffer.set_transform_static(stamped("map", "new", 1, 7.0))
    for thread in (first, second, third):
        thread.join(10)
    assert x_of(found[0]) == 7.0 and can == [True] and x_of(full[0]) == 7.0


def test_a_wait_ends_with_its_time_and_says_what_was_missing(buffer: Buffer) -> None:
    with pytest.raises(LookupException, match="nope"):
        buffer.lookup_transform("map", "nope", timeout=0.01)
    with pytest.raises(InvalidArgumentException):
        buffer.lookup_transform("/map", "nope", timeout=1e9)
    assert not buffer.can_transform("map", "nope", timeout=0.01)


def test_a_wait_ends_with_the_node(buffer: Buffer, changed: Counted) -> None:
    thread, results = in_thread(lambda: buffer.lookup_transform("map", "nope", timeout=1e6))
    await_waiting(changed)
    buffer.end_waits()
    thread.join(10)
    assert isinstance(results[0], NodeShutdownError)
    assert x_of(buffer.lookup_transform("base", "lidar", timeout=1.0)) == 0.5, "what is there is there"


def test_timeouts_count_in_the_time_that_was_given(buffer: Buffer, changed: Counted) -> None:
    """Simulated time stands still and then goes on."""
    now = [10.0]
    buffer.use_time(lambda: now[0])
    thread, results = in_thread(lambda: buffer.can_transform("map", "nope", timeout=5))
    await_waiting(changed)
    now[0] = 14.9
    buffer.wake()
    await_waiting(changed)
    now[0] = 15.1
    buffer.wake()
    thread.join(10)
    assert results == [False]


def test_waits_end_when_simulated_time_starts_again(buffer: Buffer, changed: Counted) -> None:
    """As when a bag is played in a loop: otherwise they would last until its time has come again."""
    now = [1000.0]
    buffer.use_time(lambda: now[0])
    first, can = in_thread(lambda: buffer.can_transform("map", "nope", timeout=5))
    second, found = in_thread(lambda: buffer.lookup_transform("map", "nope", timeout=5))
    await_waiting(changed, 2)
    now[0] = 1.0
    buffer.wake()
    first.join(10)
    second.join(10)
    assert can == [False] and isinstance(found[0], LookupException)


@pytest.mark.slow
def test_many_threads(buffer: Buffer) -> None:
    """Readers and writers at once: every answer belongs to one of the transforms sent."""
    stop = threading.Event()
    errors: list[BaseException] = []

    def read() -> None:
        try:
            while not stop.is_set():
                found = buffer.lookup_transform("m", "n")
                assert x_of(found) == pytest.approx(found.header.stamp.to_sec() - 200)
        except BaseException as error:  # noqa: BLE001 - shown by the test
            errors.append(error)

    buffer.set_transform(stamped("m", "n", 200))
    readers = [threading.Thread(target=read) for _ in range(3)]
    for reader in readers:
        reader.start()
    for number in range(1, 3000):
        buffer.set_transform(stamped("m", "n", 200 + number / 100, number / 100))
    stop.set()
    for reader in readers:
        reader.join(10)
    assert not errors


def test_wrong_arguments_are_named() -> None:
    buffer = Buffer()
    wrong: list[tuple[Any, str]] = [
        (lambda: Buffer("x"), "a timeout or time span must be a Duration or a number of seconds, not 'x'"),  # type: ignore[arg-type]
        (lambda: buffer.lookup_transform(5, "b"), "target_frame must be the name of a frame, not 5"),  # type: ignore[arg-type]
        (lambda: buffer.can_transform("a", None), "source_frame must be the name of a frame, not None"),  # type: ignore[arg-type]
        (lambda: buffer.lookup_transform("a", "b", "x"), "time must be a Time or a number of seconds, not 'x'"),  # type: ignore[arg-type]
        (lambda: buffer.set_transform("x"), "a transform must be a geometry_msgs/TransformStamped, not 'x'"),
    ]
    for call, text in wrong:
        with pytest.raises(TypeError, match=text):
            call()


def test_transforms_may_come_from_a_generator(buffer: Buffer) -> None:
    buffer.set_transforms((stamped("map", name, 101) for name in ("left", "right")), "/a")
    assert buffer.can_transform("left", "right", Time(101))


def test_the_tree_in_the_dot_language() -> None:
    buffer = Buffer()
    assert "no tf data" in buffer.all_frames_as_dot()
    buffer.set_transform(stamped("map", 'a "frame"', 2.0), "/me")
    assert '"map" -> "a \\"frame\\""[label="Broadcaster: /me' in buffer.all_frames_as_dot()
    assert "sec old" not in buffer.all_frames_as_dot()
    drawn = buffer.all_frames_as_dot(5.0)
    assert "( 3.000 sec old)" in drawn
    # The line that leads to the legend's box is not drawn.
    assert "edge [style=invis];\n subgraph cluster_legend" in drawn
    assert '"Recorded at time: 5.000"[ shape=plaintext ] ;\n }->"map";' in drawn


def test_times_of_a_wanted_class() -> None:
    class Mine(Time):
        __slots__ = ()

    buffer = Buffer(time_class=Mine)
    buffer.set_transform(stamped("map", "base", 2.0), "/me")
    assert type(buffer.lookup_transform("map", "base").header.stamp) is Mine
    assert type(buffer.get_latest_common_time("map", "base")) is Mine


def test_chain_at_two_times() -> None:
    buffer = Buffer()
    buffer.set_transform(stamped("map", "base", 1.0), "/me")
    buffer.set_transform(stamped("odom", "base", 2.0), "/me")
    buffer.set_transform(stamped("map", "odom", 2.0), "/me")
    assert buffer.chain_full("map", 1.0, "base", 1.0, "base") == ["base", "map"]
    assert buffer.chain_full("map", 2.0, "base", 2.0, "map") == ["base", "odom", "map"]


def test_the_same_time_again_after_further_transforms() -> None:
    buffer = Buffer(10.0)
    for seconds, x in ((1.0, 0.0), (5.0, 4.0)):
        buffer.set_transform(stamped("map", "odom", seconds, x))
    assert [x_of(buffer.lookup_transform("map", "odom", 3.0)) for _ in range(2)] == [2.0, 2.0]
    buffer.set_transform(stamped("map", "odom", 3.0, 7.0))  # late
    assert x_of(buffer.lookup_transform("map", "odom", 3.0)) == 7.0
    buffer.set_transform(stamped("map", "odom", 2.0, 1.0))
    assert x_of(buffer.lookup_transform("map", "odom", 2.5)) == 4.0
    buffer.set_transform(stamped("map", "odom", 14.0, 9.0))  # 2.5 is too old now
    with pytest.raises(ExtrapolationException):
        buffer.lookup_transform("map", "odom", 2.5)
    buffer.clear()
    with pytest.raises(TransformException):
        buffer.lookup_transform("map", "odom", 3.0)


def test_without_a_function_for_them_problems_go_to_stderr_in_tf2s_words(capsys: pytest.CaptureFixture[str]) -> None:
    buffer = Buffer()
    for child in ("b", "b", "a"):
        buffer.set_transform(stamped("a", child, 5, 0.0), "/me")
    first, second = capsys.readouterr().err.splitlines()
    assert first.startswith("Warning: TF_REPEATED_DATA ") and second.startswith("Error:   TF_SELF_TRANSFORM: ")
