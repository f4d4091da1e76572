"""pyros1.tf.transformations beside stock tf.transformations, on random and on degenerate input."""

from __future__ import annotations

import itertools
import math
import random
from typing import Any

import pytest
from tf_questions import Question, ask_stock, random_rotation, same

from pyros1.tf import transformations

AXES = [
    frame + first + second + third
    for frame in "sr"
    for first, second, third in itertools.product("xyz", repeat=3)
    if first != second != third
]


def compare(questions: list[Question]) -> None:
    answers, _ = ask_stock(questions)
    for (_, name, *arguments), (kind, stock) in zip(questions, answers, strict=True):
        assert kind == "maths", (name, arguments, stock)
        ours = plain(getattr(transformations, name)(*arguments))
        assert same(ours, stock), f"{name}{arguments}\nours:  {ours}\nstock: {stock}"


def plain(answer: Any) -> Any:
    return [plain(part) for part in answer] if isinstance(answer, (list, tuple)) else answer


def test_there_are_24_kinds_of_angles() -> None:
    assert len(AXES) == 24


@pytest.mark.parametrize("frame", ["s", "r"])
def test_euler_angles(frame: str) -> None:
    chance = random.Random(1)
    questions: list[Question] = []
    for axes in (axes for axes in AXES if axes[0] == frame):
        for _ in range(30):
            angles = [chance.choice([0.0, chance.uniform(-3, 3), math.pi / 3, chance.uniform(-7, 7)]) for _ in range(3)]
            questions += [("maths", name, *angles, axes) for name in ("quaternion_from_euler", "euler_matrix")]
            questions.append(("maths", "euler_from_quaternion", random_rotation(chance), axes))
            questions.append(("maths", "euler_from_matrix", transformations.euler_matrix(*angles, axes), axes))
        # where one angle is not determined, in numbers that are exact
        for half in (
            [0, 0, 0, 1],
            [1, 0, 0, 0],
            [0, 1, 0, 0],
            [0, 0, 1, 0],
            [0.5, 0.5, 0.5, 0.5],
            [0.5, -0.5, 0.5, 0.5],
        ):
            questions.append(("maths", "euler_from_quaternion", half, axes))
    compare(questions)


def test_quaternions_and_matrices() -> None:
    chance = random.Random(2)
    questions: list[Question] = []
    for _ in range(200):
        p, q = random_rotation(chance), random_rotation(chance)
        vector = [chance.uniform(-5, 5) for _ in range(3)]
        point = [chance.uniform(-5, 5) for _ in range(3)]
        angle, factor = chance.uniform(-7, 7), chance.uniform(-3, 3)
        moved = transformations.concatenate_matrices(
            transformations.translation_matrix(vector), transformations.quaternion_matrix(q)
        )
        calls: list[Question] = [
            ("quaternion_multiply", p, q),
            ("quaternion_conjugate", p),
            ("quaternion_inverse", p),
            ("quaternion_matrix", p),
            ("quaternion_from_matrix", transformations.quaternion_matrix(p)),
            ("quaternion_about_axis", angle, vector),
            *(("quaternion_slerp", p, q, fraction) for fraction in (0.0, 0.25, chance.random(), 1.0)),
            ("quaternion_slerp", p, q, chance.random(), 1, False),
            ("random_quaternion", [chance.random() for _ in range(3)]),
            ("random_rotation_matrix", [chance.random() for _ in range(3)]),
            ("translation_matrix", vector),
            ("translation_from_matrix", moved),
            ("rotation_matrix", angle, vector),
            ("rotation_matrix", angle, vector, point),
            ("scale_matrix", factor),
            ("scale_matrix", factor, point),
            ("scale_matrix", factor, point, vector),
            ("reflection_matrix", point, vector),
            ("concatenate_matrices", moved, transformations.rotation_matrix(angle, vector, point)),
            ("inverse_matrix", moved),
            ("is_same_transform", moved, moved),
            ("is_same_transform", moved, transformations.quaternion_matrix(p)),
            ("unit_vector", vector),
            ("vector_norm", vector),
        ]
        questions += [("maths", *call) for call in calls]
    questions += [("maths", "identity_matrix"), ("maths", "quaternion_matrix", [0, 0, 0, 0])]
    compare(questions)
