"""msgs.generator: how much code is generated."""

from __future__ import annotations

from io import BytesIO
from typing import Any

import pytest

from pyros1.msgs import from_definition
from pyros1.msgs.generator import inline_size
from pyros1.msgs.geometry_msgs.msg import Point, PoseStamped, PoseWithCovariance
from pyros1.msgs.std_msgs.msg import Empty, Header


def test_values_and_messages_are_counted() -> None:
    assert (inline_size(Empty), inline_size(Point), inline_size(Header)) == (0, 3, 3)
    assert inline_size(PoseStamped) == (1 + 3) + 1 + (1 + 3) + (1 + 4)
    assert inline_size(PoseWithCovariance) == 1 + (1 + 3) + (1 + 4) + 1  # an array is one value


def test_many_nested_messages_do_not_make_the_code_longer_and_longer(monkeypatch: pytest.MonkeyPatch) -> None:
    sizes: list[int] = []

    def compile_and_measure(source: Any, *args: Any, **options: Any) -> Any:
        sizes.append(len(source))
        return compile(source, *args, **options)

    monkeypatch.setattr("pyros1.msgs.generator.compile", compile_and_measure, raising=False)

    def code_size(count: int) -> int:
        fields = "\n".join(f"Part part{number}" for number in range(count))
        part = "\n".join(f"string name{number}" for number in range(10))
        message: Any = from_definition(f"a/Whole{count}", f"{fields}\n{'=' * 80}\nMSG: a/Part\n{part}")()
        sizes.clear()
        file = BytesIO()
        message.serialize(file)
        assert message.deserialize(file.getvalue()) == message
        return sum(sizes)

    assert 0 < code_size(60) < 1.5 * code_size(20)
