"""A robot in 3D: its URDF, the meshes of its packages, and links that move with /tf."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from browsing import Browser, Web
from PIL import Image

from pyros1.msgs.geometry_msgs.msg import TransformStamped
from pyros1.msgs.visualization_msgs.msg import Marker
from pyros1.tf import StaticTransformBroadcaster
from pyros1.web.links import panel_link

SCENE = "document.querySelector('.scene')?.scene"
ROBOT = f"{SCENE}?.displays.get('robot:/robot_description')?.display"
PROBLEM = f"{ROBOT} && {ROBOT}.problem"
CORNERS = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)]
STL_TEXT = (
    "solid a\nfacet normal 0 0 1\nouter loop\n"
    + "".join(f"vertex {x} {y} {z}\n" for x, y, z in CORNERS)
    + "endloop\nendfacet\nendsolid a\n"
)
STL = bytes(80) + struct.pack("<I", 1) + struct.pack("<12fH", 0, 0, 1, *CORNERS[0], *CORNERS[1], *CORNERS[2], 0)
OBJ = "mtllib a.mtl\nusemtl red\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n"
MTL = "newmtl red\nKd 1 0 0\nmap_Kd ../textures/a.png\n"
DAE = """<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="0.01"/><up_axis>UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="9">0 0 0 100 0 0 0 100 0</float_array><technique_common>
<accessor source="#a" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#g"/></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>"""


@pytest.fixture
def package(environ: dict[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A package ``arm`` with meshes of all kinds, for the server of the test."""
    folder = tmp_path / "src" / "arm"
    for name in ("meshes", "textures"):
        (folder / name).mkdir(parents=True)
    (folder / "package.xml").write_text("<package><name>arm</name></package>")
    files: dict[str, bytes | str] = {
        "binary.stl": STL,
        "text.STL": STL_TEXT,
        "a.obj": OBJ,
        "a.mtl": MTL,
        "z.dae": DAE.replace("UP<", "Z_UP<"),
        "y.dae": DAE.replace("UP<", "Y_UP<"),
    }
    for name, content in files.items():
        (folder / "meshes" / name).write_bytes(content.encode() if isinstance(content, str) else content)
    Image.new("RGB", (4, 4), (0, 255, 0)).save(folder / "textures" / "a.png")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "src"))
    return folder


def urdf(*shapes: str, more: str = "") -> str:
    visuals = "".join(f"<visual><geometry>{shape}</geometry>{more}</visual>" for shape in shapes)
    return f'<robot name="r"><link name="base">{visuals}</link></robot>'


def mesh(name: str) -> str:
    return f'<mesh filename="package://arm/meshes/{name}"/>'


def frame(parent: str, child: str, x: float, yaw: float = 0.0) -> TransformStamped:
    message = TransformStamped(child_frame_id=child)
    message.header.frame_id = parent
    message.transform.translation.x = x
    message.transform.rotation.z, message.transform.rotation.w = math.sin(yaw / 2), math.cos(yaw / 2)
    return message


def show(browser: Browser, link: str, word: str) -> None:
    browser.open(panel_link(link, "scene", {"fixed": "map"}))
    browser.wait(f"{ROBOT} && {ROBOT}.status === arguments[0] && {ROBOT}.loading === 0", word)


def assert_told_only_what_is_wrong(browser: Browser) -> None:
    """Check the browser's console: it tells of files that are not there, and of the page that it makes of wrong XML."""
    assert all(" 404 " in each or "inline style" in each for each in browser.complaints())


def sizes(browser: Browser) -> list[list[float]]:
    """Return the size of each mesh of the robot, in the order of its shapes."""
    found: list[list[float]] = browser.run(
        f"""const robot = {ROBOT}, sizes = [];
        robot.object.updateMatrixWorld(true);
        robot.object.traverse((each) => {{
            if (!each.isMesh) return;
            each.geometry.computeBoundingBox();
            const box = each.geometry.boundingBox.clone().applyMatrix4(each.matrixWorld);
            sizes.push([box.max.x - box.min.x, box.max.y - box.min.y, box.max.z - box.min.z]);
        }});
        return sizes;"""
    )
    return [[round(number, 3) for number in size] for size in found]


def colours(browser: Browser) -> list[str]:
    found: list[str] = browser.run(
        f"""const list = [];
        {ROBOT}.object.traverse((each) => each.isMesh && list.push(each.material.color.getHexString()));
        return list;"""
    )
    return found


def test_primitives_with_their_materials(browser: Browser, web: Web, make_node: Callable[..., Any]) -> None:
    shapes = '<box size="1 2 3"/>', '<cylinder radius="0.5" length="2"/>', '<sphere radius="0.25"/>'
    more = '<material name="orange"><color rgba="1 0.5 0 0.5"/></material>'
    make_node("robot").master.set_param("/robot_description", urdf(*shapes, more=more))
    show(browser, web.link, "r: 1 link")
    assert sizes(browser) == [[1, 2, 3], [1, 1, 2], [0.5, 0.5, 0.5]]
    assert colours(browser) == ["ff8000"] * 3
    assert (
        browser.run(f"let a; {ROBOT}.object.traverse((each) => each.isMesh && (a = each.material.opacity)); return a")
        == 0.5
    )


def test_a_link_has_one_material_as_in_rviz(browser: Browser, web: Web, make_node: Callable[..., Any]) -> None:
    box = '<geometry><box size="1 1 1"/></geometry>'
    text = (
        '<robot name="r"><material name="blue"><color rgba="0 0 1 1"/></material><link name="base">'
        f'<visual>{box}</visual><visual>{box}<material name="blue"/></visual></link></robot>'
    )
    make_node("robot").master.set_param("/robot_description", text)
    show(browser, web.link, "r: 1 link")
    assert colours(browser) == ["0000ff"] * 2


@pytest.mark.parametrize("name", ["binary.stl", "text.STL", "a.obj", "z.dae", "y.dae"])
def test_meshes_of_packages(
    browser: Browser, package: Path, web: Web, make_node: Callable[..., Any], name: str
) -> None:
    make_node("robot").master.set_param("/robot_description", urdf(mesh(name)))
    show(browser, web.link, "r: 1 link")
    assert sizes(browser) == [[1, 1, 0]]  # Collada's unit is taken, the axis that it calls up is not: as in rviz
    if name == "a.obj":
        texture = (
            f"let m; {ROBOT}.object.traverse((each) => each.isMesh && (m = each.material.map)); return m?.image.width"
        )
        assert browser.run(texture) == 4


def test_links_move_with_tf(browser: Browser, web: Web, make_node: Callable[..., Any]) -> None:
    node = make_node("robot")
    joint = '<joint name="j" type="{}"><parent link="{}"/><child link="{}"/><origin xyz="0 0 1"/></joint>'
    node.master.set_param(
        "/robot_description",
        '<robot name="r"><link name="base"/><link name="arm"/><link name="hand"/>'
        + joint.format("revolute", "base", "arm")
        + joint.format("fixed", "arm", "hand")
        + "</robot>",
    )
    show(browser, web.link, "r: 3 links")
    browser.wait_for_text("no transforms (tf) of its links: all joints are drawn at 0")
    place = f"{ROBOT}.links.get('hand').group.position.toArray()"
    assert browser.run(f"return {place}") == [0, 0, 2]
    broadcaster = StaticTransformBroadcaster(node)
    broadcaster.send_transform([frame("map", "base", 5.0), frame("base", "arm", 1.0, math.pi / 2)])
    browser.wait_for_text("no tf of hand: drawn with the joint at 0")
    assert browser.run(f"return {place}") == [6, 0, 1]
    broadcaster.send_transform([frame("arm", "hand", 2.0)])
    browser.wait(f"{ROBOT}.problem === ''")
    assert [round(number, 6) for number in browser.run(f"return {place}")] == [6, 2, 0]


def test_the_description_is_followed(browser: Browser, web: Web, make_node: Callable[..., Any]) -> None:
    master = make_node("robot").master
    show(browser, web.link, "there is no parameter /robot_description")
    master.set_param("/robot_description", urdf('<box size="1 1 1"/>'))
    browser.wait(f"{ROBOT}.status === 'r: 1 link'")
    master.set_param("/robot_description", "<robot name='other'><link name='a'/><link name='b'/></robot>")
    browser.wait(f"{ROBOT}.status === 'other: 2 links'")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("<robot><link", "this is not XML"),
        ("<launch/>", "this is not URDF: it begins with <launch>, not <robot>"),
        (urdf('<box size="1 2"/>'), 'visual of base: size="1 2" is not 3 numbers'),
        (urdf('<cylinder radius="x" length="1"/>'), 'visual of base: radius="x" is not a number'),
        (urdf("<torus/>"), "visual of base: <torus> is not a URDF shape"),
        (urdf('<mesh filename="http://evil.example/a.stl"/>'), "only package:// and file:// are supported"),
        (urdf('<mesh filename="package://arm/meshes/a.blend"/>'), "STL, OBJ and DAE are supported, not blend"),
        (urdf("<mesh filename='x.svg\"><img src=x onerror=alert(1)>'/>".replace("<img", "&lt;img")), "STL, OBJ"),
    ],
)
def test_descriptions_that_are_wrong_say_so(
    browser: Browser, web: Web, make_node: Callable[..., Any], text: str, said: str
) -> None:
    make_node("robot").master.set_param("/robot_description", text)
    browser.open(panel_link(web.link, "scene", {"fixed": "map"}))
    browser.wait(f"{PROBLEM}?.includes(arguments[0])", said)
    browser.wait_for_text(said)
    assert_told_only_what_is_wrong(browser)
    assert not browser.run("return [...document.querySelectorAll('img')].some((each) => each.src.endsWith('/x'))")


BILLION = (
    '<!DOCTYPE a [<!ENTITY a "aaaaaaaaaa">'
    + "".join(f'<!ENTITY {to} "{f"&{of};" * 10}">' for of, to in zip("abcdefghij", "bcdefghijk", strict=True))
    + "]>"
)


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("none.stl", None, "cannot be read: No such file"),
        ("short.stl", bytes(80) + struct.pack("<I", 1_000_000_000), "it claims to have 1000000000 triangles"),
        ("empty.stl", b"", "it is too short"),
        ("nan.stl", STL.replace(struct.pack("<f", 1.0), struct.pack("<f", math.nan)), "positions that are not numbers"),
        ("empty.obj", b"# nothing", "has no triangles"),
        ("cut.dae", b"<COLLADA><asset", "it is not XML"),
        ("empty.dae", b"<COLLADA/>", "cannot be read"),
        ("bomb.dae", BILLION.encode() + b"<COLLADA>&k;</COLLADA>", "it is not XML"),
    ],
    ids=lambda value: value if isinstance(value, str) and "." in value and " " not in value else "",
)
def test_meshes_that_are_wrong_say_so(
    browser: Browser,
    package: Path,
    web: Web,
    make_node: Callable[..., Any],
    name: str,
    content: bytes | None,
    said: str,
) -> None:
    if content is not None:
        (package / "meshes" / name).write_bytes(content)
    make_node("robot").master.set_param("/robot_description", urdf(mesh(name), '<box size="1 1 1"/>'))
    browser.open(panel_link(web.link, "scene", {"fixed": "map"}))
    browser.wait(f"{PROBLEM}?.includes(arguments[0])", said)
    assert sizes(browser) == [[1, 1, 1]]  # the rest is drawn
    assert_told_only_what_is_wrong(browser)


def test_a_texture_that_is_missing(browser: Browser, package: Path, web: Web, make_node: Callable[..., Any]) -> None:
    (package / "textures" / "a.png").unlink()
    make_node("robot").master.set_param("/robot_description", urdf(mesh("a.obj")))
    show(browser, web.link, "r: 1 link")
    assert sizes(browser) == [[1, 1, 0]]
    assert colours(browser) == ["ff0000"]  # its colour is better than black
    assert_told_only_what_is_wrong(browser)


def test_a_marker_that_is_a_mesh(browser: Browser, package: Path, web: Web, make_node: Callable[..., Any]) -> None:
    node = make_node("robot")
    StaticTransformBroadcaster(node).send_transform([frame("map", "base", 1.0)])
    markers = node.advertise("marks", Marker, latch=True)
    marker = Marker(type=Marker.MESH_RESOURCE, mesh_resource="package://arm/meshes/binary.stl")
    marker.header.frame_id = "base"
    marker.scale.x = marker.scale.y = marker.scale.z = 2.0
    marker.color.g = marker.color.a = 1.0
    markers.publish(marker)
    browser.open(panel_link(web.link, "scene", {"fixed": "map", "topics": ["/marks"]}))
    colour = f"""(() => {{
        let found; {SCENE}?.displays.get('/marks')?.display.object.traverse((each) => {{
            if (each.isMesh) found = each.material.color.getHexString(); }});
        return found;
    }})()"""
    assert browser.wait(colour) == "00ff00"
    marker.mesh_resource = "package://arm/meshes/none.dae"
    markers.publish(marker)
    browser.wait_for_text("No such file")
    assert_told_only_what_is_wrong(browser)


def test_a_robot_alone_is_looked_at_where_it_is(browser: Browser, web: Web, make_node: Callable[..., Any]) -> None:
    node = make_node("robot")
    node.params["/robot_description"] = "<robot name='box'><link name='base'><visual><geometry><box size='1 1 1'/>" + (
        "</geometry></visual></link></robot>"
    )
    link = TransformStamped(child_frame_id="base")
    link.header.frame_id, link.transform.translation.x, link.transform.rotation.w = "map", 50.0, 1.0
    StaticTransformBroadcaster(node).send_transform([link])
    browser.open(web.page("joints"))
    browser.wait("document.querySelector('.scene')?.scene?.stage?.controls.target.x > 49")


def test_the_view_is_fitted_though_a_mesh_has_wrong_numbers(
    package: Path, browser: Browser, web: Web, make_node: Callable[..., Any]
) -> None:
    far = struct.pack("<f", 3e38)
    (package / "meshes" / "far.stl").write_bytes(STL[:-6] + far + STL[-2:])
    node = make_node("robot")
    node.params["/robot_description"] = urdf('<box size="1 1 1"/>', mesh("far.stl"))
    browser.open(panel_link(web.link, "scene", {}))
    browser.wait(f"{ROBOT}?.status === 'r: 1 link' && {SCENE}.stage.place.name === 'orbit'")
    eye = f"Math.hypot(...{SCENE}.stage.place.position)"
    browser.wait(f"{eye} > 1 && {eye} < 5")
