"""Questions to stock tf2 and tf.transformations, answered by tf_stock.py under the stock interpreter."""

from __future__ import annotations

import json
import math
import random
import subprocess
from pathlib import Path
from typing import Any

from harness import STOCK_PYTHON

CLOSE = 1e-9
Question = tuple[Any, ...]


def ask_stock(questions: list[Question]) -> tuple[list[Any], str]:
    """Answers of stock tf2 and what it said on stderr."""
    script = Path(__file__).parent / "tf_stock.py"
    done = subprocess.run(
        [STOCK_PYTHON, str(script)],
        input=json.dumps(questions),
        env={"PATH": "/usr/bin:/bin"},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    text = done.stdout.replace("is in the buffe,", "is in the buffer,")  # stock cuts off what is longer than its array
    answers: list[Any] = json.loads(text)
    return answers, done.stderr


def same(ours: Any, stock: Any) -> bool:
    """Equal, numbers to 1e-9."""
    if isinstance(ours, list) and isinstance(stock, list):
        return len(ours) == len(stock) and all(map(same, ours, stock))
    if isinstance(ours, dict) and isinstance(stock, dict):
        return same(sorted(ours), sorted(stock)) and all(same(ours[key], stock[key]) for key in ours)
    if isinstance(ours, float) and isinstance(stock, float):
        return abs(ours - stock) <= CLOSE or ours == stock or (math.isnan(ours) and math.isnan(stock))
    return bool(ours == stock)


def random_rotation(chance: random.Random, stray: float = 0.004) -> list[float]:
    parts = [chance.gauss(0, 1) for _ in range(4)]
    length = math.sqrt(sum(part * part for part in parts))
    kind = chance.random()
    if kind < 0.1:
        return [0.0, 0.0, 0.0, chance.choice([1.0, -1.0])]
    scale = 1.0 if kind < 0.8 else 1.0 + chance.uniform(-stray, stray)
    return [part / length * scale for part in parts]
