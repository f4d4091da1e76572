"""Meshes that few programs write, and a scene of them, which rviz and our page draw alike."""

from __future__ import annotations

import struct
from collections.abc import Sequence

from rviz_scenes import GREEN_SQUARE, Markers, Scene

_TOP = 0.4
_FACES = [
    (axis, side, corners)
    for axis in range(3)
    for side in (-1, 1)
    for corners in (((-1, -1), (1, -1), (1, 1)), ((-1, -1), (1, 1), (-1, 1)))
]


def _cube() -> list[list[tuple[float, ...]]]:
    """Return the corners of a cube's triangles."""
    found = []
    for axis, side, corners in _FACES:
        places = []
        for first, second in corners[::side]:
            place = [0.0, 0.0, 0.0]
            place[axis], place[(axis + 1) % 3], place[(axis + 2) % 3] = side * _TOP, first * _TOP, second * _TOP
            places.append(tuple(place))
        found.append(places)
    return found


def _words(numbers: Sequence[float]) -> str:
    return " ".join(map(str, numbers))


def _stl_text(end: str = "endsolid cube\n") -> bytes:
    lines = ["solid cube"]
    for corners in _cube():
        vertices = "\n".join(f"vertex {_words(corner)}" for corner in corners)
        lines.append(f"facet normal 0 0 0\nouter loop\n{vertices}\nendloop\nendfacet")
    return "\n".join([*lines, end]).encode()


def _stl_binary(header: bytes) -> bytes:
    triangles = _cube()
    body = b"".join(struct.pack("<12fH", 0, 0, 0, *sum(corners, ()), 0) for corners in triangles)
    return header.ljust(80, b"\0") + struct.pack("<I", len(triangles)) + body


def _obj() -> bytes:
    lines = [f"v {_words(corner)}" for corners in _cube() for corner in corners]
    faces = [f"f {3 * index + 1} {3 * index + 2} {3 * index + 3}" for index in range(len(_cube()))]
    return "\n".join([*lines, *faces, ""]).encode()


_VERTEX = '<input semantic="VERTEX" source="#v" offset="0"/>'
_START, _END = GREEN_SQUARE.index("<triangles"), GREEN_SQUARE.index("</mesh>")
_MATERIAL = 'material="m"'


def _dae(part: str, corners: str, more: str = "", material: str = _MATERIAL) -> bytes:
    count = 2 if part == "triangles" else corners.count("<p>")  # rviz ends at a wrong one
    shape = f'<{part} count="{count}" {material}>{_VERTEX}{more}{corners}</{part}>'
    return (GREEN_SQUARE[:_START] + shape + GREEN_SQUARE[_END:]).encode()


_BOTH = "<p>0 1 2</p><p>0 2 3</p>"
_CLEAR = '<transparent opaque="A_ONE"><color>1 1 1 1</color></transparent><transparency><float>0</float></transparency>'
FILES = {
    "text_header.stl": _stl_binary(b"solid facet endsolid"),
    "no_end.stl": _stl_text(end=""),
    "text.stl": _stl_text(),
    "plain.obj": _obj(),
    "polygons.dae": _dae("polygons", _BOTH),
    "square.dae": _dae("polygons", "<p>0 1 2 3</p>"),
    "fan.dae": _dae("trifans", "<p>0 1 2 3</p>"),
    "strip.dae": _dae("tristrips", "<p>0 1 3 2</p>"),
    "plain.dae": _dae("triangles", "<p>0 1 2 0 2 3</p>", material=""),
    "clear.dae": GREEN_SQUARE.replace("</diffuse>", f"</diffuse>{_CLEAR}").encode(),
    "unbound.dae": GREEN_SQUARE.replace('symbol="m"', 'symbol="other"').encode(),
}
"""Meshes by their names in the package ``squares``."""


def odd_meshes() -> Scene:
    """Each mesh in the marker's color, with its own materials, and with those tinted."""
    some = Markers()
    for index, name in enumerate(FILES):
        mesh = f"package://squares/{name}"
        x, y = index % 6 * 2 - 6, 3 - index // 6 * 4
        some.add(x, y, 10, (1, 1, 1), mesh_resource=mesh)
        for down, tint in ((1.1, (0.0, 0.0, 0.0, 0.0)), (2.2, (1.0, 0.0, 0.0, 1.0))):
            some.add(x, y - down, 10, (1, 1, 1), tint, mesh_resource=mesh, mesh_use_embedded_materials=True)
    return some.scene("odd_meshes")
