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


def random_vector(chance: random.Random, size: int = 3) -> list[float]:
    return [chance.uniform(-5, 5) for _ in range(size)]


def test_matrices_made() -> None:
    chance = random.Random(3)
    questions: list[Question] = []
    for _ in range(100):
        point, normal, direction, eye = (random_vector(chance) for _ in range(4))
        across = sum(d * n for d, n in zip(direction, normal, strict=True)) / sum(n * n for n in normal)
        along = [d - n * across for d, n in zip(direction, normal, strict=True)]
        low, size = random_vector(chance), [chance.uniform(0.1, 5) for _ in range(3)]
        box = [bound for a, b in zip(low, size, strict=True) for bound in (a, a + b)]
        frustum = [*box[:4], 0.5, 0.5 + size[2]]
        parts = (random_vector(chance), random_vector(chance), [chance.uniform(-1.5, 1.5) for _ in range(3)], point)
        cloud = [[chance.gauss(0, 2) for _ in range(7)] for _ in range(3)]
        noisy = [[2 * x + chance.gauss(0, 0.1) for x in row] for row in (cloud[1], cloud[2], cloud[0])]
        mirrored = [[-x for x in cloud[0]], cloud[1], cloud[2]]
        composed = transformations.compose_matrix(*parts)
        calls: list[Question] = [
            ("shear_matrix", chance.uniform(-1.5, 1.5), along, point, normal),
            ("projection_matrix", point, normal),
            ("projection_matrix", point, normal, direction),
            ("projection_matrix", point, normal, None, eye),
            ("projection_matrix", point, normal, None, eye, True),
            ("clip_matrix", *box),
            ("clip_matrix", *frustum, True),
            ("orthogonalization_matrix", size, [chance.uniform(80, 100) for _ in range(3)]),
            ("compose_matrix", *parts),
            ("compose_matrix", *parts, [0.1, 0.2, 0.3, 1.5]),
            ("decompose_matrix", composed),
            ("decompose_matrix", transformations.compose_matrix(*parts, [0.01, 0.02, 0.03, 1.0])),
            ("superimposition_matrix", cloud, noisy),
            ("superimposition_matrix", cloud, noisy, True),
            ("superimposition_matrix", cloud, noisy, True, False),
            ("superimposition_matrix", cloud, mirrored),
            ("vector_norm", cloud, 1),
            ("unit_vector", cloud, 0),
            ("unit_vector", cloud),
            ("arcball_map_to_sphere", random_vector(chance, 2), [0.0, 0.5], 3.0),
            ("arcball_constrain_to_axis", transformations.unit_vector(point), transformations.unit_vector(normal)),
        ]
        questions += [("maths", *call) for call in calls]
    compare(questions)


def test_matrices_understood() -> None:
    """Several answers describe one matrix: the matrix is made again of each."""
    chance = random.Random(4)
    questions: list[Question] = []
    for _ in range(50):
        point, normal, direction, eye = (random_vector(chance) for _ in range(4))
        for name, *arguments in (
            ("rotation", chance.uniform(-3, 3), normal, point),
            ("reflection", point, normal),
            ("scale", chance.uniform(-3, 3), point),
            ("scale", chance.uniform(-3, 3), point, normal),
            ("projection", point, normal, direction),
            ("projection", point, normal, None, eye),
        ):
            matrix = getattr(transformations, f"{name}_matrix")(*arguments)
            questions.append(("maths", f"{name}_from_matrix", matrix))
    answers, _ = ask_stock(questions)
    for (_, name, matrix), (kind, stock) in zip(questions, answers, strict=True):
        assert kind == "maths", (name, matrix, stock)
        make = getattr(transformations, name.replace("_from_", "_"))
        for answer in (getattr(transformations, name)(matrix), stock):
            assert transformations.is_same_transform(make(*answer), matrix), (name, answer)


def test_every_public_function_is_there() -> None:
    answers, _ = ask_stock([("maths_names",)])
    _, names = answers[0]
    assert not set(names) - set(transformations.__all__)
