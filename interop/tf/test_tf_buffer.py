"""pyros1.tf's buffer beside stock tf2's: the same random trees, questions and clumsy input, the same answers."""

from __future__ import annotations

import math
import random
import re
from typing import Any

import pytest
from tf_cases import NS, STRANGE, TICK, random_case, settle
from tf_questions import Question, ask_stock, random_rotation, same

from pyros1.ground.timing import Time
from pyros1.msgs import load_message
from pyros1.tf import Buffer, TransformException


class Asked:
    """Our buffer behind the questions of peers/tf_stock.py."""

    def __init__(self) -> None:
        self.said: list[str] = []
        self.new(10.0)

    def new(self, keep: float) -> None:
        self.buffer = Buffer(keep, warn=self.said.append)

    def _stamped(self, parent: str, child: str, ns: int, numbers: list[float]) -> Any:
        message: Any = load_message("geometry_msgs/TransformStamped")()
        message.header.frame_id, message.child_frame_id, message.header.stamp = parent, child, Time(0, ns)
        v, q = message.transform.translation, message.transform.rotation
        v.x, v.y, v.z, q.x, q.y, q.z, q.w = numbers
        return message

    def set(self, parent: str, child: str, ns: int, numbers: list[float], authority: str) -> None:
        self.buffer.set_transform(self._stamped(parent, child, ns, numbers), authority)

    def static(self, parent: str, child: str, ns: int, numbers: list[float], authority: str) -> None:
        self.buffer.set_transform_static(self._stamped(parent, child, ns, numbers), authority)

    def clear(self) -> None:
        self.buffer.clear()

    def _numbers(self, message: Any) -> list[Any]:
        v, q = message.transform.translation, message.transform.rotation
        return [message.header.stamp.to_nsec(), [v.x, v.y, v.z, q.x, q.y, q.z, q.w]]

    def lookup(self, target: str, source: str, ns: int) -> list[Any]:
        return self._numbers(self.buffer.lookup_transform(target, source, Time(0, ns)))

    def full(self, target: str, target_ns: int, source: str, source_ns: int, fixed: str) -> list[Any]:
        times = Time(0, target_ns), Time(0, source_ns)
        return self._numbers(self.buffer.lookup_transform_full(target, times[0], source, times[1], fixed))

    def can(self, target: str, source: str, ns: int) -> list[Any]:
        why = self.buffer.why_not(target, source, Time(0, ns))
        assert self.buffer.can_transform(target, source, Time(0, ns)) is (why is None)
        return [int(why is None), why or ""]

    def can_full(self, target: str, target_ns: int, source: str, source_ns: int, fixed: str) -> list[Any]:
        arguments = (target, Time(0, target_ns), source, Time(0, source_ns), fixed)
        why = self.buffer.why_not_full(*arguments)
        assert self.buffer.can_transform_full(*arguments) is (why is None)
        return [int(why is None), why or ""]

    def common(self, target: str, source: str) -> int:
        return self.buffer.get_latest_common_time(target, source).to_nsec()

    def yaml(self) -> str:
        return self.buffer.all_frames_as_yaml()

    def string(self) -> str:
        return self.buffer.all_frames_as_string()


def ask_ours(questions: list[Question]) -> tuple[list[Any], list[str]]:
    asked = Asked()
    answers: list[Any] = []
    for word, *arguments in questions:
        try:
            answers.append([word, getattr(asked, word)(*arguments)])
        except TransformException as error:
            answers.append([type(error).__name__, str(error)])
    return answers, asked.said


def compare(questions: list[Question]) -> list[Any]:
    ours, _ = ask_ours(questions)
    stock, _ = ask_stock(questions)
    for question, mine, other in zip(questions, ours, stock, strict=True):
        settle(mine, other)
        assert same(mine, other), f"{question}\nours:  {mine}\nstock: {other}"
    return ours


@pytest.mark.parametrize("seed", range(6))
def test_random_trees_times_and_time_travel(seed: int) -> None:
    """Feature: tf: buffer, time travel, listener, broadcasters; equal to tf2 to within 1e-9 -- `pyros1.tf`"""
    questions = [question for number in range(60) for question in random_case(1000 * seed + number)]
    answers = compare(questions)
    kinds = {answer[0] for answer in answers}
    wanted = {"LookupException", "ConnectivityException", "ExtrapolationException", "InvalidArgumentException"}
    assert wanted | {"lookup", "full", "common"} <= kinds, "the cases must reach all ends"


def test_interpolation_near_and_far() -> None:
    """Rotations that hardly differ, are opposite, or are the same with another sign; all within 31 ms."""
    chance = random.Random(7)
    questions: list[Question] = []
    for angle in (0.0, 1e-12, 1e-9, 1e-7, 1e-3, 0.1, 1.0, 3.0, math.pi, math.pi - 1e-9, 4.0, 2 * math.pi):
        for _ in range(20):
            questions.append(("new", 10.0))
            x, y, z, w = random_rotation(chance, 0)
            axis = random_rotation(chance, 0)[:3]
            length = math.sqrt(sum(part * part for part in axis)) or 1.0
            s, c = math.sin(angle / 2) / length, math.cos(angle / 2)
            a, b, d = (part * s for part in axis)
            turned = [
                w * a + x * c + y * d - z * b,
                w * b + y * c + z * a - x * d,
                w * d + z * c + x * b - y * a,
                w * c - x * a - y * b - z * d,
            ]
            size = math.sqrt(sum(part * part for part in turned))
            turned = [part / size * chance.choice([1, -1]) for part in turned]
            questions.append(("set", "a", "b", 5 * NS, [0.0, 1.0, 2.0, x, y, z, w], "me"))
            questions.append(("set", "a", "b", 5 * NS + 16 * TICK, [1.0, 1e6, -2.0, *turned], "me"))
            for _ in range(4):
                questions.append(("lookup", *chance.choice(["ab", "ba"]), 5 * NS + chance.randint(0, 16) * TICK))
    compare(questions)


def test_loops() -> None:
    unit = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]
    questions: list[Question] = [
        ("set", "a", "b", NS, unit, "me"),
        ("set", "b", "c", NS, unit, "me"),
        ("set", "c", "a", NS, unit, "me"),
        ("set", "c", "d", NS, unit, "me"),
        ("set", "m", "n", NS, unit, "me"),
    ]
    for target in "abcdmn":
        for source in "abcdmn":
            for when in (0, NS, 2 * NS):
                questions += [("lookup", target, source, when), ("can", target, source, when)]
            questions.append(("full", target, 0, source, NS, "b"))
    compare(questions)


def test_strange_input_and_what_is_said_about_it() -> None:
    compare(STRANGE)
    _, ours = ask_ours(STRANGE)
    _, stderr = ask_stock(STRANGE)
    stock = re.findall(r"^(?:Warning|Error): +(.*)$", stderr, re.MULTILINE)
    assert ours == [text for text in stock if "canTransform argument" not in text]
    assert len(ours) >= 12
