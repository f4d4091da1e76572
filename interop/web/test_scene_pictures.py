"""The 3D panel beside rviz: for the same messages, displays and view, both show the same colours at the same places."""

from __future__ import annotations

import base64
import io
import os
import random
import re
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
import yaml
from browsing import Browser
from numpy.typing import NDArray
from PIL import Image
from rviz import HEIGHT, WIDTH, WINDOW, Picture, Rviz, is_here, start_rviz
from rviz_odd_meshes import FILES, odd_meshes
from rviz_odd_scenes import ODD_SCENES
from rviz_scenes import GREEN_SQUARE, SCENES, Scene, any_markers

from pyros1.master.server import Master
from pyros1.node import Node
from pyros1.tf import StaticTransformBroadcaster
from pyros1.web.links import panel_link
from pyros1.web.scene.rviz.file import read_rviz

pytestmark = pytest.mark.once

PATIENCE = 30.0
BLOCK = 20
"""Pixels of the blocks that are compared."""
GREY = 48
"""What is behind all in rviz, as red, green and blue."""
PAINTED = 24
"""How much a channel differs from that, at least, where something is drawn."""
COVERED, TINT = 0.3, 0.3
"""How much a block may differ in what is painted of it, and in colours from 0 to 1."""
SCENE = "document.querySelector('.scene')?.scene"
LIKE_RVIZ = f"""
    const {{stage}} = {SCENE};
    stage.parent.style.cssText = 'position:fixed; left:0; top:0; width:{WIDTH}px; height:{HEIGHT}px; z-index:9';
    stage.resize();
    stage.renderer.setClearColor('rgb({GREY}, {GREY}, {GREY})');
    if (stage.camera.isOrthographicCamera) stage.camera.zoom *= arguments[0];
    stage.camera.updateProjectionMatrix();
"""
PIXELS = f"const {{stage}} = {SCENE}; stage.render(); return stage.canvas.toDataURL('image/png')"
SAVED = Path(__file__).parents[2] / "tests" / "web" / "scene" / "rviz_saved.yaml"
PLUGINS = Path("/usr/share/rviz/plugin_description.xml")
ALL = {**SCENES, **ODD_SCENES, "odd_meshes": odd_meshes}
Blocks = NDArray[np.float64]


class Robot(NamedTuple):
    """One system for all scenes: rviz and the server of the page look at it."""

    environ: dict[str, str]
    rviz: Rviz
    link: str


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Robot]:
    """A master, rviz, and ``pyros1 web``."""
    if not is_here():
        if os.environ.get("PYROS1_REQUIRE_STOCK"):
            pytest.fail("rviz or Xvfb is missing: interop/setup installs them")
        pytest.skip("rviz and Xvfb are not installed")
    folder = tmp_path_factory.mktemp("rviz")
    master = Master(port=0, bind_host="127.0.0.1")
    master.start()
    package = folder / "src" / "squares"
    package.mkdir(parents=True)
    (package / "package.xml").write_text("<package><name>squares</name></package>")
    for name, content in {"green.dae": GREEN_SQUARE.encode(), **FILES}.items():
        (package / name).write_bytes(content)
    environ = {"ROS_MASTER_URI": master.uri, "ROS_HOSTNAME": "localhost", "ROS_HOME": str(folder / "ros")}
    environ["ROS_PACKAGE_PATH"] = f"{package.parent}:/usr/share"  # where Debian's rviz is
    words = [sys.executable, "-m", "pyros1", "web", "--port", "0"]
    web = subprocess.Popen(
        words, env={**os.environ, **environ}, stdout=subprocess.PIPE, stdin=subprocess.DEVNULL, text=True
    )
    try:
        assert web.stdout is not None
        match = re.search(r"http://\S+\Z", web.stdout.readline().strip())
        assert match
        with start_rviz(environ, folder) as rviz:
            yield Robot(environ, rviz, match[0])
    finally:
        web.terminate()
        web.communicate(timeout=10)
        master.stop()


@pytest.fixture
def browser(_driver: Any, robot: Robot) -> Iterator[Browser]:
    """A browser for pages of this module's server."""
    found = Browser(_driver)
    found.complaints()
    found.resize(1280, 900)
    yield found
    found.driver.get("about:blank")
    _driver.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
    assert not found.complaints()


@pytest.fixture
def show(robot: Robot, browser: Browser, tmp_path: Path) -> Iterator[Callable[[Scene], None]]:
    """Return a function that publishes a scene, and shows it in rviz and on the page."""
    nodes: list[Node] = []

    def show(scene: Scene) -> None:
        node = Node(f"scene{time.monotonic_ns()}", argv=[], environ=robot.environ, handle_signals=False)
        nodes.append(node)
        StaticTransformBroadcaster(node).send_transform(scene.frames)
        for topic, message in scene.messages:
            if hasattr(message, "header"):
                message.header.frame_id = message.header.frame_id or "map"
            node.advertise(topic, type(message), latch=True).publish(message)
        manager = {
            "Displays": [{"Enabled": True, "Value": True, **each} for each in scene.displays],
            "Global Options": {"Background Color": "; ".join([str(GREY)] * 3), "Fixed Frame": "map", "Frame Rate": 30},
            "Tools": [{"Class": "rviz/MoveCamera"}],
            "Views": {"Current": scene.view},
        }
        content = yaml.safe_dump({"Panels": [], "Visualization Manager": manager, "Window Geometry": WINDOW})
        file = tmp_path / "scene.rviz"
        file.write_text(content)
        robot.rviz.load(file)
        settings, notes = read_rviz(content, str)
        assert notes == []
        browser.open(panel_link(robot.link, "scene", settings))
        browser.wait(f"Boolean({SCENE}?.stage && {SCENE}.mouse)")
        browser.run(LIKE_RVIZ, WINDOW["Height"] / HEIGHT)

    yield show
    for node in nodes:
        node.shutdown()


def ours(browser: Browser) -> Picture:
    data = base64.b64decode(browser.run(PIXELS).partition(",")[2])
    return np.array(Image.open(io.BytesIO(data)).convert("RGB"))


def blocks(picture: Picture) -> tuple[Blocks, Blocks]:
    """Return how much of each block is painted, and the mean colour of what is."""
    rows, columns = HEIGHT // BLOCK, WIDTH // BLOCK
    parts = picture[: rows * BLOCK, : columns * BLOCK].astype(float).reshape(rows, BLOCK, columns, BLOCK, 3)
    painted = (np.abs(parts - GREY).max(axis=-1, keepdims=True) > PAINTED).astype(float)
    count = painted.sum(axis=(1, 3))
    return count[..., 0] / BLOCK**2, (parts * painted).sum(axis=(1, 3)) / np.maximum(count, 1)


def difference(theirs: Picture, our: Picture) -> str:
    """Return where two pictures differ: more of a block is painted, or in another colour; empty if nowhere.

    Colours are compared at the same brightness: rviz's light comes from the eye, ours from above.
    """
    (covered, tints), (our_covered, our_tints) = blocks(theirs), blocks(our)
    wrong = np.abs(covered - our_covered) > COVERED
    seen = (np.minimum(covered, our_covered) > 0.15) & (tints.max(axis=-1) > GREY)
    wrong |= seen & (np.abs(at_full_brightness(tints) - at_full_brightness(our_tints)).max(axis=-1) > TINT)
    said = []
    for row, column in np.argwhere(wrong):
        both = (covered, tints), (our_covered, our_tints)
        rviz, we = (f"{much[row, column]:.2f} in {tint[row, column].astype(int).tolist()}" for much, tint in both)
        said.append(f"at ({(column + 0.5) * BLOCK:.0f}, {(row + 0.5) * BLOCK:.0f}) rviz paints {rviz}, we {we}")
    return "\n".join(said)


def at_full_brightness(tints: Blocks) -> Blocks:
    found: Blocks = tints / np.maximum(tints.max(axis=-1, keepdims=True), 1)
    return found


def compare(robot: Robot, browser: Browser, tmp_path: Path) -> None:
    """Wait until both show the same, and something."""
    until = time.monotonic() + PATIENCE
    while True:
        theirs, our = robot.rviz.picture(), ours(browser)
        found = difference(theirs, our)
        if not found and blocks(theirs)[0].any():
            return
        if time.monotonic() > until:
            file = tmp_path / "both.png"
            Image.fromarray(np.hstack([theirs, our])).save(file)
            raise AssertionError(f"{file} has rviz's picture and ours:\n{found or 'both are empty'}")
        time.sleep(0.2)


@pytest.mark.parametrize("name", sorted(ALL))
def test_a_scene_looks_as_in_rviz(
    name: str, robot: Robot, browser: Browser, show: Callable[[Scene], None], tmp_path: Path
) -> None:
    show(ALL[name]())
    compare(robot, browser, tmp_path)


def test_any_markers_look_as_in_rviz(
    robot: Robot, browser: Browser, show: Callable[[Scene], None], tmp_path: Path
) -> None:
    seed = random.randrange(1 << 32)
    show(any_markers(seed))
    try:
        compare(robot, browser, tmp_path)
    except AssertionError as error:
        raise AssertionError(f"markers of seed {seed}: {error}") from None


def test_rviz_writes_the_properties_that_the_tests_of_files_know(robot: Robot, tmp_path: Path) -> None:
    """tests/web/scene/test_rviz_properties.py changes each of them; a new one belongs into its file."""
    known = yaml.safe_load(SAVED.read_text())["Visualization Manager"]["Displays"]
    classes = re.findall(r'name="(rviz/\w+)"[^>]*base_class_type="rviz::Display"', PLUGINS.read_text())
    bare = [{"Class": each, "Name": each.partition("/")[2], "Enabled": False} for each in classes]
    begun, saved = tmp_path / "bare.rviz", tmp_path / "saved.rviz"
    begun.write_text(yaml.safe_dump({"Visualization Manager": {"Displays": bare}}))
    robot.rviz.load(begun)
    robot.rviz.save(saved)
    written = yaml.safe_load(saved.read_text())["Visualization Manager"]["Displays"]
    assert [{**each, **_visibility(each)} for each in written] == [{**each, **_visibility(each)} for each in known]


def _visibility(display: dict[str, Any]) -> dict[str, Any]:
    """A camera has one for each display beside it."""
    return {"Visibility": None} if "Visibility" in display else {}
