"""The programs map_server and map_saver.

Feature: map_server and map_saver, with the topics, services and files of the originals
"""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pyros1.msgs.nav_msgs.msg import MapMetaData, OccupancyGrid
from pyros1.robot_nodes.map_server import saver, server
from pyros1.robot_nodes.map_server.loading import load_map
from pyros1.robot_nodes.map_server.messages import make_grid, read_grid

PATIENCE = 20.0
YAML = "image: floor.pgm\nresolution: 0.5\norigin: [1, 2, 0.5]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"


@pytest.fixture
def maps(tmp_path: Path, environ: dict[str, str], monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a map, and a package of one more."""
    for name, value in environ.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path))
    for folder, picture in ((tmp_path, b"P5 3 1 255 \0\xff\xcd"), (tmp_path / "house", b"P2 2 1 255 255 0")):
        folder.mkdir(exist_ok=True)
        (folder / "floor.pgm").write_bytes(picture)
        (folder / "floor.yaml").write_text(YAML)
    (tmp_path / "house" / "package.xml").write_text("<package><name>house</name></package>")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run_until(main: Callable[[list[str]], int], words: list[str], check: Callable[[], object]) -> int:
    """Run a program, which a check in another thread ends as Ctrl-C does."""
    problems: list[BaseException] = []

    def look() -> None:
        try:
            check()
        except BaseException as error:  # noqa: BLE001 - raised below
            problems.append(error)
        os.kill(os.getpid(), signal.SIGINT)

    looking = threading.Thread(target=look)
    looking.start()
    code = main(words)
    looking.join(PATIENCE)
    for problem in problems:
        raise problem
    return code


def test_map_server(maps: Path, make_node: Any) -> None:
    user = make_node("user")

    def check() -> None:
        user.wait_for_service("static_map", PATIENCE)
        grid = user.wait_for_message("map", OccupancyGrid, PATIENCE)
        assert (list(grid.data), grid.header.frame_id) == ([100, 0, -1], "floor")
        info = user.wait_for_message("map_metadata", MapMetaData, PATIENCE)
        assert (info.width, info.height, info.resolution) == (3, 1, 0.5)
        assert info.map_load_time == grid.header.stamp and grid.header.stamp.to_sec() > 0
        assert read_grid(grid)[1] == pytest.approx((1, 2, 0.5))
        assert user.service("static_map", "nav_msgs/GetMap")().map == grid
        change = user.service("change_map", "nav_msgs/LoadMap")
        for url, result in [
            ("nowhere.yaml", 1),
            ("https://example.com/floor.yaml", 1),
            ("floor.pgm", 3),
            ("package://nothing/floor.yaml", 255),
        ]:
            assert change(url).result == result, url
        (maps / "floor.pgm").write_bytes(b"P5 3 1 255 ")
        assert change(f"file://{maps}/floor.yaml").result == 2
        assert list(user.service("static_map", "nav_msgs/GetMap")().map.data) == [100, 0, -1]
        response = change("package://house/floor.yaml")
        assert (response.result, list(response.map.data)) == (0, [0, 100])
        assert list(user.wait_for_message("map", OccupancyGrid, PATIENCE).data) == [0, 100]

    assert run_until(server.main, ["map_server", "floor.yaml", "__name:=maps", "_frame_id:=floor"], check) == 0


def test_a_picture_and_its_resolution(maps: Path, make_node: Any) -> None:
    user = make_node("user")

    def check() -> None:
        grid = user.wait_for_message("map", OccupancyGrid, PATIENCE)
        assert (list(grid.data), grid.info.resolution) == ([0, 100, 100], 0.25)
        assert grid.header.frame_id == "map"

    assert run_until(server.main, ["map_server", "floor.pgm", "0.25", "_negate:=1"], check) == 0


@pytest.mark.parametrize(
    ("words", "code", "text"),
    [
        ([], 1, "usage: map_server MAP.yaml"),
        (["a", "b", "c"], 1, "usage: map_server MAP.yaml"),
        (["--help"], 0, "usage: map_server MAP.yaml"),
        (["nowhere.yaml"], 1, "nowhere.yaml: cannot be read: No such file"),
        (["floor.pgm", "fine"], 1, "RESOLUTION must be a positive number (metres per pixel), not 'fine'"),
        (["floor.pgm", "0"], 1, "RESOLUTION must be"),
    ],
)
def test_wrong_arguments(maps: Path, capfd: pytest.CaptureFixture[str], words: list[str], code: int, text: str) -> None:
    assert server.main(["map_server", *words]) == code
    assert text in capfd.readouterr().err


def test_map_saver(maps: Path, make_node: Any) -> None:
    cells = np.array([[0, 100, -1], [30, 70, 0]], np.int8)
    make_node("slam").advertise("grid", OccupancyGrid, latch=True).publish(make_grid(cells, 0.25, (-1.0, 2.0, 0.5)))
    (maps / "out").mkdir()
    assert saver.main(["map_saver", "-f", "out/saved", "map:=grid"]) == 0
    saved = load_map("out/saved.yaml")
    assert (saved.cells.tolist(), saved.resolution) == ([[0, 100, -1], [-1, 100, 0]], 0.25)
    assert saved.origin == pytest.approx((-1.0, 2.0, 0.5))
    assert saver.main(["map_saver", "--occ", "90", "--free", "30", "map:=grid"]) == 0
    assert load_map("map.yaml").cells.tolist() == [[0, 100, -1], [0, -1, 0]]
    assert {file.name for file in (maps / "out").iterdir()} == {"saved.yaml", "saved.pgm"}


def test_map_saver_reports_what_is_wrong(maps: Path, make_node: Any, capfd: pytest.CaptureFixture[str]) -> None:
    publisher = make_node("slam").advertise("map", OccupancyGrid, latch=True)
    publisher.publish(make_grid(np.zeros((1, 2), np.int8), 0.25, (0.0, 0.0, 0.0)))
    assert saver.main(["map_saver", "-f", "nowhere/saved"]) == 1
    assert "nowhere/saved.pgm cannot be written: No such file" in capfd.readouterr().err
    broken = make_grid(np.zeros((1, 2), np.int8), 0.25, (0.0, 0.0, 0.0))
    broken.info.height = 3
    publisher.publish(broken)
    assert saver.main(["map_saver"]) == 1
    assert "the map has 2 cells instead of 2 x 3" in capfd.readouterr().err


def test_waiting_for_a_map_can_be_interrupted(maps: Path, make_node: Any, capfd: pytest.CaptureFixture[str]) -> None:
    user = make_node("user")
    publisher = user.advertise("other", OccupancyGrid)

    def check() -> None:
        assert publisher.wait_for_subscribers(timeout=PATIENCE)

    assert run_until(saver.main, ["map_saver", "map:=other"], check) == 1
    assert "no map was saved" in capfd.readouterr().err


@pytest.mark.parametrize(
    "words", [["--occ", "0"], ["--occ", "101"], ["--free", "-1"], ["--free", "65"], ["--occ", "x"], ["-f"], ["more"]]
)
def test_wrong_options_of_map_saver(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        saver.main(["map_saver", *words])
    assert end.value.code == 2 and "usage: map_saver" in capsys.readouterr().err
