from __future__ import annotations

import os
import sys
from pathlib import Path

import numpy as np
import pytest

from pyros1.robot_nodes.map_server.errors import MapDataError, MapError, MapMetadataError, MapMissingError
from pyros1.robot_nodes.map_server.loading import load_map

YAML = "image: {}\nresolution: 0.1\norigin: [1, 2, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
PGM = b"P5 2 2 255 \0\xff\xff\xcd"
CELLS = [[0, -1], [100, 0]]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "floor.pgm").write_bytes(PGM)
    (tmp_path / "floor.yaml").write_text(YAML.format("floor.pgm"))
    return tmp_path


@pytest.mark.parametrize("is_absolute", [False, True])
def test_a_picture_beside_its_description(
    folder: Path, is_absolute: bool, tmp_path_factory: pytest.TempPathFactory
) -> None:
    file = folder / "floor.yaml"
    if is_absolute:
        file = tmp_path_factory.mktemp("other") / "floor.yaml"
        file.write_text(YAML.format(folder / "floor.pgm"))
    cells, resolution, origin = load_map(str(file))
    assert (cells.tolist(), resolution, origin) == (CELLS, 0.1, (1.0, 2.0, 0.0))


@pytest.mark.parametrize("mode", ["L", "RGB", "I;16"])
def test_other_formats(folder: Path, mode: str) -> None:
    """Maps in PNG; of 16 bits, the upper 8 count."""
    image = pytest.importorskip("PIL.Image")
    pixels = np.array([[0, 255], [255, 205]], np.uint16 if mode == "I;16" else np.uint8)
    pixels = pixels * 256 + 7 if mode == "I;16" else pixels
    image.fromarray(np.dstack([pixels] * 3) if mode == "RGB" else pixels).save(folder / "floor.png")
    (folder / "floor.yaml").write_text(YAML.format("floor.png"))
    assert load_map(str(folder / "floor.yaml")).cells.tolist() == CELLS


def test_transparent_pixels_are_unknown_in_scale(folder: Path) -> None:
    image = pytest.importorskip("PIL.Image")
    image.fromarray(np.array([[[0, 0, 0, 0], [0, 0, 0, 255]]], np.uint8)).save(folder / "floor.png")
    (folder / "floor.yaml").write_text(YAML.format("floor.png") + "mode: scale\n")
    assert load_map(str(folder / "floor.yaml")).cells.tolist() == [[-1, 100]]


def test_pictures_with_fractions_are_refused(folder: Path) -> None:
    image = pytest.importorskip("PIL.Image")
    image.fromarray(np.ones((2, 2), np.float32)).save(folder / "floor.pgm", "TIFF")
    with pytest.raises(MapDataError, match=r"floor.pgm: pictures with pixels of float32 cannot be maps"):
        load_map(str(folder / "floor.yaml"))


@pytest.mark.parametrize(
    ("change", "error_class", "problem"),
    [
        ({"floor.yaml": None}, MapMissingError, "floor.yaml: cannot be read: No such file"),
        ({"floor.pgm": None}, MapMissingError, "floor.pgm: cannot be read: No such file"),
        ({"floor.yaml": b"x"}, MapMetadataError, "floor.yaml: it must be YAML with image"),
        ({"floor.yaml": b"\xff\xfe"}, MapMetadataError, "floor.yaml: "),
        ({"floor.yaml": b"#" * ((1 << 20) + 1)}, MapDataError, "floor.yaml: too large: at most 1 MiB"),
        ({"floor.pgm": b"P5 2 2 255 "}, MapDataError, "floor.pgm: the PGM file is cut off"),
        ({"floor.pgm": b"\x89PNG\r\n\x1a\nxx"}, MapDataError, "floor.pgm: "),
        ({"floor.pgm": b""}, MapDataError, "floor.pgm: "),
    ],
)
def test_damaged_maps(folder: Path, change: dict[str, bytes | None], error_class: type[MapError], problem: str) -> None:
    for name, data in change.items():
        (folder / name).unlink() if data is None else (folder / name).write_bytes(data)
    with pytest.raises(error_class, match=problem):
        load_map(str(folder / "floor.yaml"))


def test_without_pillow(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "PIL.Image", None)
    (folder / "floor.pgm").write_bytes(b"\x89PNG\r\n\x1a\n")
    with pytest.raises(MapDataError, match=r"floor.pgm: .* need Pillow: pip install 'pyros1\[images\]'"):
        load_map(str(folder / "floor.yaml"))


def test_a_relative_path_is_reported_with_its_folder(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """roslaunch starts nodes in another folder than the user's."""
    monkeypatch.chdir(folder)
    with pytest.raises(MapMissingError, match=rf"No such file or directory \(in the folder {folder}; .* full path\)"):
        load_map("nowhere.yaml")
    with pytest.raises(MapMissingError, match=r"No such file or directory$"):
        load_map(str(folder / "nowhere.yaml"))


def test_pipes_and_devices_are_no_maps(folder: Path) -> None:
    """Reading them would wait for ever."""
    os.mkfifo(folder / "pipe")
    description = (folder / "floor.yaml").read_text()
    (folder / "device.yaml").write_text(description.replace("floor.pgm", "pipe"))
    for name in ("pipe", "device.yaml"):
        with pytest.raises(MapMissingError, match="pipe: cannot be read: It is not a regular file"):
            load_map(str(folder / name))
