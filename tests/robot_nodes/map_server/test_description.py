from __future__ import annotations

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from pyros1.robot_nodes.map_server.description import Description, format_description, parse_description
from pyros1.robot_nodes.map_server.errors import MapMetadataError

COMPLETE = {
    "image": "floor.pgm",
    "resolution": 0.05,
    "origin": [-1.0, 2, 0.5],
    "negate": 0,
    "occupied_thresh": 0.65,
    "free_thresh": 0.196,
}


def test_a_usual_file() -> None:
    expected = Description("floor.pgm", 0.05, (-1.0, 2.0, 0.5))
    assert parse_description(yaml.safe_dump(COMPLETE)) == expected
    changes = {"negate": 1, "mode": "scale", "occupied_thresh": 0.9, "free_thresh": 0.1}
    expected = expected._replace(negate=True, mode="scale", occupied_thresh=0.9, free_thresh=0.1)
    assert parse_description(yaml.safe_dump(COMPLETE | changes)) == expected


def test_numbers_as_other_programs_write_them() -> None:
    text = "image: a\nresolution: 5e-2\norigin: [-1e1, .5, 0]\nnegate: false\noccupied_thresh: 1\nfree_thresh: '0.2'\n"
    assert parse_description(text) == Description("a", 0.05, (-10.0, 0.5, 0.0), False, 1.0, 0.2)


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        *(({name: None}, f"{name} must be") for name in COMPLETE),
        ({"image": ""}, "image must be the path of a picture, not ''"),
        ({"resolution": 0}, "resolution must be a number of metres above 0, not 0.0"),
        ({"resolution": "fine"}, "resolution must be a number, not 'fine'"),
        ({"origin": [1, 2]}, r"origin must be \[x, y, yaw\], not \[1, 2\]"),
        ({"origin": [1, 2, float("nan")]}, "origin must be"),
        ({"origin": 3}, "origin must be"),
        ({"free_thresh": float("inf")}, "free_thresh must be a number, not inf"),
        ({"negate": [0]}, "negate must be a number"),
        ({"mode": "grey\n"}, r"mode must be trinary, scale or raw, not 'grey\\n'"),
    ],
)
def test_values_that_cannot_be_used(change: dict[str, object], problem: str) -> None:
    with pytest.raises(MapMetadataError, match=problem):
        parse_description(yaml.safe_dump(COMPLETE | change))


@pytest.mark.parametrize("text", ["", "[]", "{", "a: b: c", "\0", "[" * 5000])
def test_what_is_no_description(text: str) -> None:
    with pytest.raises(MapMetadataError):
        parse_description(text)


@given(st.floats(0.001, 10), st.tuples(*[st.floats(-1e4, 1e4)] * 3))
def test_what_is_written_is_read(resolution: float, origin: tuple[float, float, float]) -> None:
    text = format_description("floor.pgm", resolution, origin)
    assert yaml.safe_load(text).keys() == COMPLETE.keys()
    read = parse_description(text)
    assert read.image == "floor.pgm"
    assert read[3:] == Description("", 1.0)[3:]
    assert (read.resolution, *read.origin) == pytest.approx((resolution, *origin), abs=1e-6)
