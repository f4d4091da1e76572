"""Random and strange questions to a buffer of tf2, see tf_stock.py, and the differences that are meant."""

from __future__ import annotations

import math
import random
from typing import Any

from tf_questions import Question, random_rotation

NS = 1_000_000_000
TICK = 1_953_125  # ns, 1/512 s: stock's Python hands times over as doubles, which hold multiples of this exactly


def settle(mine: list[Any], other: list[Any]) -> None:
    """Make equal what differs on purpose: ours says more."""
    if mine[0] == "common" or other[:1] == ["TransformException"]:
        # tf2's get_latest_common_time has one kind of error for loops and for frames that are not connected
        if other[0] == "TransformException" and mine[0] in ("ConnectivityException", "LookupException"):
            other[0] = mine[0]
            other[1] = other[1] or mine[1]
    elif mine[0] in ("can", "can_full") and not mine[1][0]:
        # tf2 does not tell the caller which name is bad, and mixes up which of three frames is missing
        if not other[1][1] or "fixed_frame" in other[1][1]:
            assert mine[1][1]
            other[1][1] = mine[1][1]
        elif "does not exist" in other[1][1]:
            assert mine[1][1].startswith(other[1][1])
            other[1][1] = mine[1][1]


def random_case(seed: int) -> list[Question]:
    """A tree that grows, changes its parents now and then and forgets, and questions all the while."""
    chance = random.Random(seed)
    frames = [f"f{number}" for number in range(chance.randint(2, 12))]
    parents = {frames[i]: chance.choice(frames[:i]) for i in range(1, len(frames)) if chance.random() < 0.93}
    static = {frame for frame in parents if chance.random() < 0.3}
    clumsy = chance.random() < 0.3  # wrong names, loops, both kinds of transforms of one frame
    base = chance.choice([3, 1_700_000_000]) * NS
    names = [*frames, "nope", "/f1", ""] if clumsy else frames
    questions: list[Question] = [("new", chance.choice([10.0, 2.0, 0.5]))]
    now = base
    for _ in range(chance.randint(20, 120)):
        now += TICK * (chance.choice([0, 5, 71, 512, 1536]) if chance.random() < 0.5 else chance.randrange(512))
        for child in chance.sample(list(parents), chance.randint(0, len(parents))):
            parent = parents[child]
            if chance.random() < 0.02:
                above = chance.choice(frames if clumsy else frames[: frames.index(child)])
                parent = parents[child] = above
            stamp = max(0, now + chance.choice([0, 0, 0, -51 * TICK, -2 * NS, -11 * NS, TICK * chance.randrange(512)]))
            if clumsy and chance.random() < 0.02:
                stamp = 0
            transform = [chance.uniform(-100, 100) for _ in range(3)] + random_rotation(chance)
            kind = child in static
            if clumsy and chance.random() < 0.02:
                kind = not kind
            slash = "/" if chance.random() < 0.05 else ""
            word = "static" if kind else "set"
            questions.append((word, slash + parent, child, stamp, transform, f"/node{chance.randint(1, 3)}"))
        if chance.random() < 0.01:
            questions.append(("clear",))
        for _ in range(chance.randint(0, 8)):
            target, source, fixed = (chance.choice(names) for _ in range(3))
            when, then = (
                chance.choice([0, max(0, now - TICK * chance.randrange(6000)), now, now - 10 * TICK]) for _ in range(2)
            )
            questions.append(("lookup", target, source, when))
            questions.append(("can", target, source, when))
            questions.append(("full", target, when, source, then, fixed))
            questions.append(("can_full", target, when, source, then, fixed))
            questions.append(("common", target, source))
    questions += [("yaml",), ("string",)]
    return questions


STRANGE: list[Question] = [
    ("set", "a", "a", NS, [0, 0, 0, 0, 0, 0, 1], "/n"),
    ("set", "a", "", NS, [0, 0, 0, 0, 0, 0, 1], "/n"),
    ("set", "", "b", NS, [0, 0, 0, 0, 0, 0, 1], "/n"),
    ("set", "", "", NS, [0, 0, 0, 0, 0, 0, 0], "/m"),
    ("set", "/a", "/c", NS, [math.nan, 0, 0, 0, 0, 0, 1], "/n"),
    ("set", "a", "d", NS, [0, 0, 0, math.nan, 0, 0, 1], "/n"),
    ("set", "a", "e", NS, [0, 0, 0, 0, 0, 0, 1.1], "/n"),
    ("set", "a", "f", NS, [0, 0, 0, 0, 0, 0, 1.00498], "/n"),
    ("set", "a", "g", NS, [0, 0, 0, 0, 0, 0, 1.00499], "/n"),
    ("set", "a", "h", NS, [0, 0, 0, 0, 0, 0, 0.99498], "/n"),
    ("set", "a", "i", NS, [0, 0, 0, 0, 0, 0, 0], "/n"),
    ("set", "a", "inf", NS, [math.inf, -math.inf, 0, 0, 0, 0, 1], "/n"),
    ("set", "p", "k", 20 * NS, [0, 0, 0, 0, 0, 0, 1], "/n"),
    ("set", "p", "k", 20 * NS, [1, 0, 0, 0, 0, 0, 1], "/n"),
    ("set", "p", "k", 10 * NS, [2, 0, 0, 0, 0, 0, 1], "/n"),
    ("set", "q", "k", 10 * NS - 1, [2, 0, 0, 0, 0, 0, 1], "/m"),
    ("static", "a", "s", 5 * NS, [3, 0, 0, 0, 0, 0, 1], "/n"),
    ("static", "a", "s", 5 * NS, [4, 0, 0, 0, 0, 0, 1], "/m"),
    ("set", "a", "s", 6 * NS, [5, 0, 0, 0, 0, 0, 1], "/n"),
    ("string",),
    ("yaml",),
    ("lookup", "a", "s", 0),
    ("lookup", "a", "s", NS),
    ("lookup", "nope", "nope", 0),
    ("lookup", "/nope", "/nope", 3),
    ("lookup", "", "", 3),
    ("can", "", "", 3),
    ("can", "/k", "k", 0),
    ("full", "", 0, "", 0, ""),
    ("full", "k", 0, "k", 0, "/k"),
    ("full", "k", 20 * NS, "k", 10 * NS, "p"),
    ("full", "p", 0, "p", 0, "p"),
    ("clear",),
    ("string",),
    ("yaml",),
    ("lookup", "a", "s", NS),
    ("lookup", "p", "k", 0),
    ("lookup", "p", "k", NS),
]
