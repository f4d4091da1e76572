"""repeats: lines that others cause are counted."""

from __future__ import annotations

from typing import Any

from pyros1.net.rate_limit import MAX_TEXTS, PERIOD, RepeatCounter


class Timers:
    """Calls that are due later, when the test says so."""

    def __init__(self) -> None:
        self.due: list[tuple[Any, Any]] = []

    def __call__(self, seconds: float, function: Any, argument: Any) -> None:
        assert seconds == PERIOD
        self.due.append((function, argument))

    def run(self) -> None:
        due, self.due = self.due, []
        for function, argument in due:
            function(argument)


def test_a_text_is_written_once_and_then_counted() -> None:
    timers, lines = Timers(), []
    repeats = RepeatCounter(timers)
    for _ in range(38):
        repeats.log("here", "refused", lines.append)
    repeats.log("here", "refused another", lines.append)
    assert lines == ["refused", "refused another"]
    timers.run()
    assert lines[2:] == ["refused (repeated 37 times)"]
    repeats.log("here", "refused", lines.append)
    assert lines[3:] == ["refused"]


def test_texts_that_differ_are_bounded_for_each_place() -> None:
    timers, lines = Timers(), []
    repeats = RepeatCounter(timers)
    for number in range(1000):
        repeats.log("here", f"refused {number}", lines.append)
    repeats.log("there", "lost", lines.append)
    assert lines == [*(f"refused {number}" for number in range(MAX_TEXTS)), "lost"]
    timers.run()
    assert lines[-1] == f"{1000 - MAX_TEXTS} similar messages were suppressed"


def test_what_was_counted_is_told_at_the_end() -> None:
    timers, lines = Timers(), []
    repeats = RepeatCounter(timers)
    for _ in range(2):
        repeats.log("here", "refused", lines.append)
    repeats.close()
    timers.run()
    assert lines == ["refused", "refused (repeated once)"]


def test_a_signal_handler_may_end_it_at_any_moment() -> None:
    lines: list[str] = []
    repeats = RepeatCounter(Timers())

    class Interrupting(str):
        """A text on top of whose looking up a handler comes."""

        def __hash__(self) -> int:
            repeats.close()
            return super().__hash__()

    repeats.log("here", Interrupting("refused"), lines.append)
    assert lines == ["refused"]


def test_a_place_may_have_a_lower_bound() -> None:
    timers, lines = Timers(), []
    repeats = RepeatCounter(timers)
    for number in range(31):
        repeats.log("here", f"/talker_{number} is gone", lines.append, max_texts=3)
    assert lines == [f"/talker_{number} is gone" for number in range(3)]
    timers.run()
    assert lines[3:] == ["28 similar messages were suppressed"]
