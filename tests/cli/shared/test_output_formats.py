"""Forms of messages: rows with times as offsets."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from pyros1.cli.shared.output_formats import PlotFormat
from pyros1.ground.timing import Time
from pyros1.msgs.geometry_msgs.msg import PointStamped
from pyros1.msgs.std_msgs.msg import Float64, Header


@pytest.mark.parametrize(
    ("message", "offset", "row"),
    [
        (Float64(2.0), False, "7000000000,2.0"),
        (Float64(2.0), True, "0,2.0"),  # stock shows how long it takes for this
        (PointStamped(header=Header(stamp=Time(5))), False, "5000000000,0,5000000000,,0.0,0.0,0.0"),
        (PointStamped(header=Header(stamp=Time(5))), True, "-2000000000,0,-2000000000,,0.0,0.0,0.0"),
    ],
)
def test_times_of_rows(message: Any, offset: bool, row: str) -> None:
    written: list[str] = []
    options = SimpleNamespace(offset=offset, bag=None, nostr=False, noarr=False)
    PlotFormat(options, lambda: Time(7))(message, message, None, written.append)
    assert "".join(written).splitlines()[1] == row
