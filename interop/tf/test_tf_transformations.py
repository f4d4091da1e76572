"""pyros1.tf.transformations beside stock: results and their types, on random and on degenerate input.

Feature: tf.transformations: the same names, arguments, results and errors, using numpy --
    `pyros1.tf.transformations`; lookups need no numpy
"""

from __future__ import annotations

import itertools
import math
import random
from typing import Any

import numpy as np
import pytest
from tf_questions import Question, ask_stock, random_rotation, same
from tf_values import described, made

from pyros1.tf import transformations

pytestmark = pytest.mark.filterwarnings("ignore::RuntimeWarning")  # numpy's, of nan

AXES = [
    frame + first + second + third
    for frame in "sr"
    for first, second, third in itertools.product("xyz", repeat=3)
    if first != second != third
]
ZERO, X, NAN = [0, 0, 0], [1, 0, 0], math.nan
NOTHING, MANY = np.zeros((4, 4)).tolist(), np.arange(16).reshape(4, 4).tolist()
IDENTITY, NO_LAST = np.identity(4).tolist(), np.diag([1, 1, 1, 0]).tolist()


def answers_of(calls: list[Question]) -> list[tuple[Question, Any, Any]]:
    """What both answer to calls: described, or the name of the error."""
    stock, _ = ask_stock([("maths", name, *map(described, arguments)) for name, *arguments in calls])
    found = []
    for (name, *arguments), (kind, answer) in zip(calls, stock, strict=True):
        try:
            ours = described(getattr(transformations, name)(*(made(described(argument)) for argument in arguments)))
        except Exception as error:  # noqa: BLE001 - an answer, too
            ours = type(error).__name__
        found.append(((name, *arguments), ours, answer if kind == "maths" else kind))
    return found


def compare(calls: list[Question], errors: bool = False) -> None:
    for (name, *arguments), ours, stock in answers_of(calls):
        assert errors or not isinstance(stock, str), (name, arguments, stock)
        assert same(ours, stock), f"{name}{tuple(arguments)}\nours:  {ours}\nstock: {stock}"


def any_form(chance: random.Random, argument: Any) -> Any:
    """The argument, or, if it is a list, perhaps as a tuple, as an array, or with numbers that are not looked at."""
    if not isinstance(argument, list):
        return argument
    if len(argument) == 3 and isinstance(argument[0], float) and chance.random() < 0.3:
        argument = [*argument, 7.0]
    tuples = tuple(tuple(part) if isinstance(part, list) else part for part in argument)
    return chance.choice([argument, tuples, np.array(argument), np.array(argument, order="F")])


def in_any_form(chance: random.Random, calls: list[Question], exactly: tuple[str, ...] = ()) -> list[Question]:
    return [
        (name, *(argument if name in exactly else any_form(chance, argument) for argument in arguments))
        for name, *arguments in calls
    ]


def test_there_are_24_kinds_of_angles() -> None:
    assert len(AXES) == 24


@pytest.mark.parametrize("frame", ["s", "r"])
def test_euler_angles(frame: str) -> None:
    chance = random.Random(1)
    calls: list[Question] = []
    for axes in (axes for axes in AXES if axes[0] == frame):
        for _ in range(30):
            angles = [chance.choice([0.0, chance.uniform(-3, 3), math.pi / 3, chance.uniform(-7, 7)]) for _ in range(3)]
            calls += [(name, *angles, axes) for name in ("quaternion_from_euler", "euler_matrix")]
            calls.append(("euler_from_quaternion", random_rotation(chance), axes))
            matrix = transformations.euler_matrix(*angles, axes)
            calls.append(("euler_from_matrix", (matrix * chance.choice([1, 3]))[: chance.choice([3, 4])], axes))
        # where one angle is not determined, in numbers that are exact
        for half in (
            [0, 0, 0, 1],
            [1, 0, 0, 0],
            [0, 1, 0, 0],
            [0, 0, 1, 0],
            [0.5, 0.5, 0.5, 0.5],
            [0.5, -0.5, 0.5, 0.5],
        ):
            calls.append(("euler_from_quaternion", half, axes))
    compare(in_any_form(chance, calls))


def test_codes_of_axes() -> None:
    names = "quaternion_from_euler", "euler_matrix"
    codes = list(itertools.product(range(-1, 4), range(2), range(2), range(2)))
    calls: list[Question] = [(name, 0.1, 0.2, 0.3, code) for code in codes for name in names]
    calls += [(name, 0.1, 0.2, 0.3, axes) for axes in ("", "xyz", "sxxz", "qxyz", "sxyzz", None) for name in names]
    compare([*calls, ("quaternion_from_euler", 0.1, 0.2, 0.3, "RZYX"), ("euler_from_matrix", IDENTITY, "no")], True)


def test_quaternions() -> None:
    chance = random.Random(2)
    calls: list[Question] = []
    for _ in range(200):
        p, q, length = random_rotation(chance), random_rotation(chance), chance.choice([1.0, chance.uniform(0.1, 3)])
        vector, angle = [chance.uniform(-5, 5) for _ in range(3)], chance.uniform(-7, 7)
        turn = transformations.quaternion_matrix(p)
        calls += [
            ("quaternion_multiply", p, q),
            ("quaternion_conjugate", p),
            ("quaternion_inverse", [length * part for part in p]),
            ("quaternion_matrix", [length * part for part in p]),
            ("quaternion_matrix", np.array(p, "float32")),
            ("quaternion_from_matrix", turn),
            ("quaternion_from_matrix", turn.tolist()),
            ("quaternion_from_matrix", length * turn),
            ("quaternion_from_matrix", turn.astype("float32")),
            ("quaternion_from_matrix", (np.array(turn) + [chance.gauss(0, 0.01) for _ in range(4)])),
            ("quaternion_about_axis", angle, vector),
            *(("quaternion_slerp", p, q, fraction) for fraction in (0.0, 0.25, chance.random(), 1.0, 0, 1, 1.5)),
            ("quaternion_slerp", p, q, chance.random(), 1, False),
            ("quaternion_slerp", p, q, chance.random(), 2),
            ("random_quaternion", [chance.random() for _ in range(3)]),
        ]
        calls.append(("random_rotation_matrix", calls[-1][1]))
    compare(in_any_form(chance, calls, exactly=("random_quaternion", "random_rotation_matrix")))


def test_lengths() -> None:
    chance = random.Random(3)
    calls: list[Question] = []
    for shape in ((0,), (1,), (3,), (4,), (2, 3), (3, 3), (1, 4), (2, 3, 4)):
        data = np.array([chance.uniform(-5, 5) for _ in range(math.prod(shape))]).reshape(shape)
        forms = data, data.tolist(), data.astype("float32"), data.astype("int32"), np.asfortranarray(data)
        axes = None, *range(-len(shape), len(shape))
        calls += [(name, form, axis) for name in ("vector_norm", "unit_vector") for form in forms for axis in axes]
        calls += [(name, data, len(shape)) for name in ("vector_norm", "unit_vector") if len(shape) > 1]
    compare([*calls, ("vector_norm", 5), ("unit_vector", ZERO), ("unit_vector", [ZERO, X], 1)], errors=True)


def random_vector(chance: random.Random, size: int = 3) -> list[float]:
    return [chance.uniform(-5, 5) for _ in range(size)]


def test_matrices() -> None:
    chance = random.Random(4)
    calls: list[Question] = []
    for _ in range(100):
        point, normal, direction, eye = (random_vector(chance) for _ in range(4))
        across = sum(d * n for d, n in zip(direction, normal, strict=True)) / sum(n * n for n in normal)
        along = [d - n * across for d, n in zip(direction, normal, strict=True)]
        low, size = random_vector(chance), [chance.uniform(0.1, 5) for _ in range(3)]
        box = [bound for a, b in zip(low, size, strict=True) for bound in (a, a + b)]
        angle, factor = chance.uniform(-7, 7), chance.uniform(-3, 3)
        parts = (random_vector(chance), random_vector(chance), [chance.uniform(-1.5, 1.5) for _ in range(3)], point)
        composed = transformations.compose_matrix(*parts).tolist()
        turned = transformations.rotation_matrix(angle, normal, point).tolist()
        cloud = [[chance.gauss(0, 2) for _ in range(7)] for _ in range(3)]
        noisy = [[2 * x + chance.gauss(0, 0.1) for x in row] for row in (cloud[1], cloud[2], cloud[0])]
        mirrored = [[-x for x in cloud[0]], cloud[1], cloud[2]]
        calls += [
            ("translation_matrix", point),
            ("translation_from_matrix", composed),
            ("rotation_matrix", angle, direction),
            ("rotation_matrix", angle, direction, point),
            ("scale_matrix", factor),
            ("scale_matrix", factor, point),
            ("scale_matrix", factor, point, direction),
            ("scale_matrix", factor, None, direction),
            ("reflection_matrix", point, normal),
            ("shear_matrix", chance.uniform(-1.5, 1.5), along, point, normal),
            ("projection_matrix", point, normal),
            ("projection_matrix", point, normal, direction),
            ("projection_matrix", point, normal, None, eye),
            ("projection_matrix", point, normal, None, eye, True),
            ("projection_matrix", point, normal, direction, eye),
            ("clip_matrix", *box),
            ("clip_matrix", *box[:4], 0.5, 0.5 + size[2], True),
            ("orthogonalization_matrix", size, [chance.uniform(80, 100) for _ in range(3)]),
            ("compose_matrix", *parts),
            ("compose_matrix", *parts, [0.1, 0.2, 0.3, 1.5]),
            *(("compose_matrix", *(part if chance.random() < 0.5 else None for part in parts)) for _ in range(3)),
            ("decompose_matrix", composed),
            ("decompose_matrix", turned),
            ("decompose_matrix", transformations.compose_matrix(*parts, [0.01, 0.02, 0.03, 1.0])),
            ("concatenate_matrices", composed, turned, *[IDENTITY] * chance.choice([0, 1, 2])),
            ("inverse_matrix", composed),
            ("inverse_matrix", [row[:3] for row in turned[:3]]),
            ("is_same_transform", composed, (chance.choice([1, 2.5, 1 + 1e-9]) * np.array(composed)).tolist()),
            ("is_same_transform", composed, turned),
            *(("superimposition_matrix", cloud, end, *how) for end in (noisy, mirrored) for how in ((), (True, False))),
            ("superimposition_matrix", cloud, noisy, True),
        ]
    calls += [("identity_matrix",), ("concatenate_matrices",), ("compose_matrix",)]
    compare(in_any_form(chance, calls, exactly=("orthogonalization_matrix",)))


def without_choice(answer: Any, where: int) -> Any:
    """The answer without what may be chosen: the point on an axis or plane, the signs of direction and angle."""
    answer["tuple"][where]["array"] = None
    for part in answer["tuple"]:
        if isinstance(part, dict) and part["array"]:
            part["array"] = [abs(number) for number in part["array"]]
    return [abs(part) if isinstance(part, float) else part for part in answer["tuple"]]


def test_what_a_matrix_does() -> None:
    """The matrix is made again of what both say, as several answers are right."""
    chance = random.Random(5)
    calls: list[Question] = []
    for _ in range(50):
        point, normal, direction, eye = (random_vector(chance) for _ in range(4))
        for name, *arguments in (
            ("rotation", chance.uniform(-3, 3), normal, point),
            ("rotation", math.pi, normal, point),
            ("rotation", 1.5, chance.choice([[0, 0, 1], [0, -1, 0], X])),
            ("reflection", point, normal),
            ("scale", chance.uniform(-3, 3), point),
            ("scale", chance.uniform(-3, 3), point, normal),
            ("projection", point, normal, direction),
            ("projection", point, normal, None, eye),
        ):
            matrix = getattr(transformations, f"{name}_matrix")(*arguments)
            calls.append((f"{name}_from_matrix", chance.choice([matrix, matrix.tolist()])))
    for (name, matrix), ours, stock in answers_of(calls):
        make = getattr(transformations, name.replace("_from_", "_"))
        for answer in (ours, stock):
            assert transformations.is_same_transform(make(*made(answer)), matrix), (name, answer)
        where = {"rotation": 2, "reflection": 0, "scale": 1, "projection": 0}[name.partition("_")[0]]
        assert ours["tuple"][where]["array"][3] == 1.0
        assert same(without_choice(ours, where), without_choice(stock, where)), (name, matrix, ours, stock)


def test_degenerate_arguments() -> None:
    quaternion, nan_matrix = [0, 0, 0, 1], [[NAN] * 4] * 4
    calls: list[Question] = [
        *(("quaternion_matrix", q) for q in ([0] * 4, [1e-8, 0, 0, 0], [3e-8, 0, 0, 0], [1, 2, 3, 4, 5], [NAN] * 4)),
        *(("euler_from_quaternion", q) for q in ([0] * 4, [0, math.sqrt(0.5), 0, math.sqrt(0.5)], [1, 2, 3, 4, 5])),
        *((name, [0] * 4) for name in ("quaternion_inverse", "quaternion_conjugate")),
        *(("quaternion_slerp", quaternion, [0, 0, part, 1], 0.5) for part in (0, 1e-9, 1e-7)),
        *(("quaternion_slerp", quaternion, [0, 0, 0, -1], 0.5, 0, short) for short in (True, False)),
        *(("quaternion_slerp", [0] * 4, quaternion, fraction) for fraction in (0, 0.5, 1)),
        ("quaternion_slerp", [0, 0, 0, 2], [0, 0, 3, 0], True),
        *(("quaternion_multiply", p, quaternion) for p in ([1, 2, 3], [1, 2, 3, 4, 5], np.arange(4, dtype="float32"))),
        *(("quaternion_about_axis", 1, axis) for axis in (ZERO, [1e-17, 0, 0], [1, 2, 3, 4], [])),
        *(("quaternion_from_matrix", m) for m in (NOTHING, MANY, np.diag([1, 1, 1, -1]), np.eye(3), np.eye(5))),
        *(("quaternion_from_matrix", transformations.scale_matrix(factor)) for factor in (-2, -1, 0.5, 2)),
        *(("quaternion_from_matrix", transformations.rotation_matrix(math.pi, axis)) for axis in ([1, -2, 3], X)),
        *(("euler_from_matrix", m) for m in (NOTHING, MANY, np.zeros((3, 3)), np.eye(2), nan_matrix)),
        *(("euler_from_matrix", transformations.euler_matrix(1, a, 0.3, x), x) for a in (0, math.pi / 2) for x in AXES),
        ("random_quaternion", [2, 0.2, 0.3]),
        *(("random_vector", size) for size in (0, (0, 3), -1, 2.5)),
        *(("translation_matrix", vector) for vector in ([1, 2], [1], [])),
        *(("translation_from_matrix", m) for m in (np.zeros((4, 4)), np.ones((3, 4)), np.eye(3), [1.0, 2.0])),
        *(("rotation_matrix", 1, *more) for more in ((ZERO,), (ZERO, X), ([1, 2],), (X, [1, 2]))),
        *(("scale_matrix", 2, *more) for more in ((None, ZERO), ([1, 2],), ([], X), ([1, 2], [1, 2]))),
        *(("reflection_matrix", *given) for given in ((X, ZERO), ([1, 2], X), (X, [0, 1]), (NAN, X))[:3]),
        *(("shear_matrix", 1, X, X, normal) for normal in (X, [1, 0, 1], [1.1e-6, 0, 1], [9e-7, 0, 1])),
        *(("shear_matrix", 1, *given) for given in ((ZERO, X, [0, 0, 1]), (X, [1, 2], [0, 0, 1]))),
        *(("projection_matrix", X, *more) for more in ((ZERO,), (ZERO, None, X), (X, None, X), (X, ZERO))),
        ("projection_matrix", X, X, None, None, True),
        *(("clip_matrix", 0, 1, 0, 1, near, 2, True) for near in (0, -1, 1e-20, 1e-9)),
        *(("clip_matrix", *box) for box in ((1, 1, 0, 1, 1, 2), (0, 1, 2, 1, 1, 2), (0, 1, 0, 1, 1, -2))),
        *(("orthogonalization_matrix", X, angles) for angles in ([90] * 3, [0, 80, 70], [90, 0, 70], [10, 80, 70])),
        *(("orthogonalization_matrix", *given) for given in (([1, 2], [90] * 3), ([1, 2, 3, 4], [90] * 3))),
        *(("compose_matrix", None, None, None, None, last) for last in ([1, 2, 3], [1, 2, 3, 0], [0, 0, 0, 2])),
        *(
            ("decompose_matrix", m)
            for m in (NOTHING, NO_LAST, IDENTITY, np.diag([0, 1, 1, 1]), np.diag([-1, -2, -3, 2]))
        ),
        *(("decompose_matrix", m) for m in (np.diag([1e-20] * 3 + [1]), np.diag([-1, -2, -3, 2]), np.eye(3))),
        *(("superimposition_matrix", a, a) for a in (np.zeros((3, 4)), np.zeros((3, 2)), np.eye(2), np.zeros((3, 0)))),
        ("superimposition_matrix", np.zeros((3, 4)), np.zeros((3, 4)), True, False),
        ("superimposition_matrix", np.eye(3), np.ones((3, 4))),
        *(("concatenate_matrices", np.eye(4), other) for other in (np.eye(3), [1, 2, 3, 4], np.ones((4, 2)))),
        ("concatenate_matrices", np.eye(4, dtype="float32"), np.eye(4, dtype="int8")),
        *(("inverse_matrix", m) for m in (NOTHING, np.ones((4, 3)), [1, 2], [[2]], np.stack([np.eye(4)] * 3))),
        *(("is_same_transform", IDENTITY, m) for m in (NOTHING, np.eye(5), -np.eye(4), np.eye(4) + 1e-6, NO_LAST)),
        *((f"{name}_from_matrix", m) for name in ("reflection", "projection") for m in (IDENTITY, NOTHING)),
        *((f"{name}_from_matrix", m) for name in ("rotation", "scale", "shear") for m in (NOTHING, MANY, np.eye(3))),
        *((f"{name}_from_matrix", np.diag([2, 2, 2, 1])) for name in ("rotation", "reflection", "shear", "projection")),
        *((f"{name}_from_matrix", np.diag([2, 2, 2, 2])) for name in ("rotation", "scale", "reflection", "shear")),
        ("rotation_from_matrix", IDENTITY),
        *(("scale_from_matrix", np.diag(d)) for d in ([0, 0, 0, 1], [1, 2, 3, 1], [0, 1, 1, 1], [-1, 1, 1, 1])),
    ]
    compare(calls, errors=True)


def kind_of(answer: Any) -> str:
    """The name of an error, the dtype of an array, or the type of anything else."""
    return answer if isinstance(answer, str) else str(answer.get("dtype") or next(iter(answer)))


@pytest.mark.parametrize(
    ("ours", "stock", "call"),
    [
        ("ValueError", "tuple", ("shear_from_matrix", IDENTITY)),
        ("ValueError", "tuple", ("projection_from_matrix", IDENTITY, True)),
        ("ValueError", "IndexError", ("shear_from_matrix", transformations.scale_matrix(2, X, [1, 1, 1]))),
        ("ValueError", "IndexError", ("quaternion_matrix", [1, 2, 3])),
        ("ValueError", "IndexError", ("quaternion_conjugate", [1, 2, 3])),
        ("ValueError", "IndexError", ("compose_matrix", [1, 2])),
        ("ValueError", "AssertionError", ("random_quaternion", [0.1, 0.2])),
        ("IndexError", "TypeError", ("translation_matrix", 5)),
        ("float64", "KeyError", ("euler_matrix", 0.1, 0.2, 0.3, "SXYZ")),
        ("float64", "int64", ("translation_from_matrix", np.ones((4, 4), "int64"))),
        ("float64", "float32", ("inverse_matrix", np.eye(3, dtype="float32"))),
    ],
)
def test_results_of_another_kind(ours: str, stock: str, call: Question) -> None:
    """See differences.md."""
    ((_, *answers),) = answers_of([call])
    assert [*map(kind_of, answers)] == [ours, stock]


def test_points_and_angles_where_stock_has_rounding() -> None:
    """See differences.md."""
    move = transformations.translation_matrix([1, 2, 3])
    screw = move @ transformations.rotation_matrix(0.5, X)
    shear = transformations.shear_matrix(1, [1, 1, 0], [1, 2, 3], [1, -1, -1])
    upright = transformations.euler_matrix(0.1, math.pi / 2, 0.3)
    calls: list[Question] = [
        ("rotation_from_matrix", screw),
        ("scale_from_matrix", move @ transformations.scale_matrix(2, None, X)),
        ("shear_from_matrix", shear),
        ("decompose_matrix", upright),
    ]
    (_, turn, _), (_, scale, _), (_, ours, stock), (_, *pieces) = answers_of(calls)
    assert screw @ made(turn)[2] - made(turn)[2] == pytest.approx([*X, 0]), "a point of the axis moves along it"
    assert made(scale)[1] == pytest.approx([-1, 0, 0, 1])
    assert (made(ours)[0], made(stock)[0]) == (pytest.approx(1, abs=1e-12), pytest.approx(1, abs=1e-3))
    assert transformations.is_same_transform(transformations.shear_matrix(*made(ours)), shear)
    for piece in pieces:
        assert transformations.is_same_transform(transformations.compose_matrix(*made(piece)), upright)
    assert made(pieces[0])[2][2] == 0.0


def test_every_public_function_is_there() -> None:
    answers, _ = ask_stock([("maths_names",)])
    _, names = answers[0]
    assert set(names) == set(transformations.__all__)
