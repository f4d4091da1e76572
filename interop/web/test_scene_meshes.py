"""Meshes whose normals are absent, zero, no numbers or of any length look like those with right ones."""

from __future__ import annotations

import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browsing import Browser, Web
from PIL import Image

from pyros1.web.links import panel_link

ROBOT = "document.querySelector('.scene')?.scene?.displays.get('robot:/robot_description')?.display"
NORMALS = f"""
    const found = [];
    {ROBOT}.object.traverse((each) => each.isMesh && found.push(...each.geometry.getAttribute("normal").array));
    return found.map((each) => (Number.isFinite(each) ? each : "none"));
"""
Facet = tuple[tuple[float, ...], list[tuple[float, ...]]]
KINDS: dict[str, Callable[[tuple[float, ...], int], tuple[float, ...] | None]] = {
    "right": lambda normal, _: normal,
    "zero": lambda *_: (0.0, 0.0, 0.0),
    "no numbers": lambda *_: (float("nan"), 0.0, 1.0),
    "infinite": lambda *_: (0.0, float("inf"), 0.0),
    "long and short": lambda normal, number: tuple(each * (30.0, 0.2)[number % 2] for each in normal),
    "of some": lambda normal, number: normal if number % 3 else (0.0, 0.0, 0.0),
    "absent": lambda *_: None,
}


def cube() -> list[Facet]:
    """Return the triangles of a cube of 1 m."""
    facets: list[Facet] = []
    for axis in range(3):
        for side in (-1.0, 1.0):
            corners = []
            for first, second in ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)):
                place = [0.0, 0.0, 0.0]
                place[axis], place[(axis + 1) % 3], place[(axis + 2) % 3] = side / 2, first, second
                corners.append(tuple(place))
            normal = tuple(side if each == axis else 0.0 for each in range(3))
            corners = corners if side > 0 else corners[::-1]
            facets += [(normal, [corners[0], corners[1], corners[2]]), (normal, [corners[0], corners[2], corners[3]])]
    return facets


def words(numbers: tuple[float, ...]) -> str:
    return " ".join(str(each) for each in numbers)


def stl_binary(kind: str) -> bytes:
    facets = [(KINDS[kind](normal, number) or (0.0,) * 3, corners) for number, (normal, corners) in enumerate(cube())]
    body = b"".join(struct.pack("<12fH", *normal, *sum(corners, ()), 0) for normal, corners in facets)
    return bytes(80) + struct.pack("<I", len(facets)) + body


def stl_text(kind: str) -> bytes:
    lines = ["solid cube"]
    for number, (normal, corners) in enumerate(cube()):
        lines.append(f"facet normal {words(KINDS[kind](normal, number) or (0.0,) * 3)}\nouter loop")
        lines += [f"vertex {words(corner)}" for corner in corners]
        lines.append("endloop\nendfacet")
    return "\n".join([*lines, "endsolid cube", ""]).encode()


def obj(kind: str) -> bytes:
    lines = ["o cube"]
    for number, (normal, corners) in enumerate(cube()):
        lines += [f"v {words(corner)}" for corner in corners]
        found = KINDS[kind](normal, number)
        lines += [f"vn {words(found)}"] if found else []
        end = f"//{number + 1}" if found else ""
        lines.append("f " + " ".join(f"{3 * number + each}{end}" for each in (1, 2, 3)))
    return "\n".join([*lines, ""]).encode()


def source(name: str, values: list[tuple[float, ...]]) -> str:
    axes = "".join(f'<param name="{axis}" type="float"/>' for axis in "XYZ")
    return (
        f'<source id="{name}"><float_array id="{name}-a" count="{3 * len(values)}">'
        f"{' '.join(words(each) for each in values)}</float_array><technique_common>"
        f'<accessor source="#{name}-a" count="{len(values)}" stride="3">{axes}</accessor></technique_common></source>'
    )


def dae(kind: str) -> bytes:
    places = [corner for _, corners in cube() for corner in corners]
    normals = [KINDS[kind](normal, number) for number, (normal, _) in enumerate(cube())]
    given = [each for each in normals if each is not None]
    wanted = '<input semantic="NORMAL" source="#n" offset="1"/>' if given else ""
    pairs = " ".join(f"{each} {each // 3}" if given else str(each) for each in range(len(places)))
    return f"""<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="1"/><up_axis>Z_UP</up_axis></asset><library_geometries><geometry id="g"><mesh>
{source("p", places)}{source("n", given) if given else ""}
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices><triangles count="{len(places) // 3}">
<input semantic="VERTEX" source="#v" offset="0"/>{wanted}<p>{pairs}</p></triangles></mesh></geometry>
</library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="k"><instance_geometry url="#g"/></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>""".encode()


FORMATS = {"binary.stl": stl_binary, "text.stl": stl_text, "a.obj": obj, "a.dae": dae}


@pytest.fixture
def meshes(environ: dict[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder with the meshes of a package ``cubes``: each format with each kind of normals."""
    folder = tmp_path / "src" / "cubes"
    (folder / "meshes").mkdir(parents=True)
    (folder / "package.xml").write_text("<package><name>cubes</name></package>")
    for name, content in FORMATS.items():
        for kind in KINDS:
            (folder / "meshes" / f"{kind.replace(' ', '_')}_{name}").write_bytes(content(kind))
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "src"))
    return folder / "meshes"


@pytest.mark.parametrize("name", FORMATS)
def test_normals_that_say_nothing_are_computed(
    browser: Browser, meshes: Path, web: Web, make_node: Callable[..., Any], tmp_path: Path, name: str
) -> None:
    node = make_node("robot")
    pictures = {}
    for kind in KINDS:
        uri = f"package://cubes/meshes/{kind.replace(' ', '_')}_{name}"
        node.master.set_param(
            "/robot_description",
            f'<robot name="r"><link name="base"><visual><geometry><mesh filename="{uri}"/></geometry>'
            '<material name="orange"><color rgba="1 0.5 0 1"/></material></visual></link></robot>',
        )
        browser.open(panel_link(web.link, "scene", {"fixed": "base"}))
        browser.wait(f"{ROBOT} && {ROBOT}.status === 'r: 1 link' && {ROBOT}.loading === 0")
        browser.wait(f"{ROBOT}.object.visible")
        normals = np.array(browser.run(NORMALS)).reshape(-1, 3)
        expected = np.repeat([normal for normal, _ in cube()], 3, axis=0)
        assert np.allclose(normals, expected, atol=1e-4), (name, kind, normals[:3])
        picture = tmp_path / f"{kind}.png"
        browser.picture(picture)
        pictures[kind] = picture
    seen = {kind: middle(picture) for kind, picture in pictures.items()}
    assert seen["right"].max(axis=2).min() > 60, f"{pictures['right']} shows a black cube"
    differences = {kind: float(np.abs(each - seen["right"]).mean()) for kind, each in seen.items()}
    assert max(differences.values()) < 2, differences


WRONG = {
    "corner.stl": (stl_text("right").replace(b"vertex", b"vertx", 1), "it has 12 triangles, but 35 corners"),
    "cut.stl": (stl_binary("right")[:-20], "it claims to have 12 triangles, but has 664 bytes"),
    "scene.dae": (dae("right").replace(b"<instance_visual_scene", b"<instance"), "it has no scene"),
}


def test_wrong_files_are_named(browser: Browser, meshes: Path, web: Web, make_node: Callable[..., Any]) -> None:
    shapes = ""
    for name, (content, _) in WRONG.items():
        (meshes / name).write_bytes(content)
        shapes += f'<visual><geometry><mesh filename="package://cubes/meshes/{name}"/></geometry></visual>'
    make_node("robot").master.set_param(
        "/robot_description", f'<robot name="r"><link name="base">{shapes}</link></robot>'
    )
    browser.open(panel_link(web.link, "scene", {"fixed": "base"}))
    browser.wait(f"{ROBOT}?.faults.length === {len(WRONG)}")
    expected = [f"package://cubes/meshes/{name} cannot be read: {why}" for name, (_, why) in WRONG.items()]
    assert sorted(browser.run(f"return {ROBOT}.faults")) == sorted(expected)


def middle(picture: Path) -> Any:
    """Return the colours of the middle of the page, which is filled by the cube."""
    with Image.open(picture) as image:
        pixels = np.asarray(image.convert("RGB")).astype(int)
    return pixels[300:420, 640:880]
