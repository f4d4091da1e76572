"""Compressed images of every codec, depth and number of channels: read and written by cv_bridge with OpenCV, as stock
has it, by ours with Pillow alone, and by ours with OpenCV. The files are random; a failure names their seed.

Feature: compressed images as OpenCV reads and writes them -- `cv_bridge` with Pillow alone, or with OpenCV: JPEG, and
    PNG of 1 to 16 bits, with opacity
"""

from __future__ import annotations

import ast
import random
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from faces import command, environ
from harness import STOCK_PYTHON, Master

MASTERS = ("ours",)
OWN_MASTER = True
pytestmark = pytest.mark.ours_only
PROGRAM = Path(__file__).parent / "programs" / "image_files.py"
CONVERSIONS = PROGRAM.with_name("image_conversions.py")
OURS = ["ours", "ours with OpenCV"]
OVERFLOWING = ("mono16", "bgr16", "rgb16", "bgra16", "rgba16", "16UC3", "8UC3", "8SC3")
Images = dict[tuple[str, str], Any]


def run(face: str, master: Master, *words: str, program: Path = PROGRAM) -> str:
    surroundings = environ(face.split(maxsplit=1)[0], master)
    words = (*command(face, program), *words)
    if "OpenCV" in face:
        surroundings["PYROS1_ROSPY"] = "pyros1"
        words = (STOCK_PYTHON, *words[1:])
    done = subprocess.run(words, env=surroundings, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, f"on {face}: {done.stderr[-3000:]}"
    return done.stdout


def read(face: str, master: Master, folder: Path) -> Images:
    """Return what is read from each file in each encoding: an array, None, or "error"."""
    found: Images = {}
    for line in run(face, master, "read", str(folder)).splitlines():
        name, encoding, text = line.split(" ", 2)
        value = text if text == "error" else ast.literal_eval(text)
        if isinstance(value, tuple):
            shape, kind, data = value
            value = np.frombuffer(bytes.fromhex(data), kind).reshape(shape)
        found[name, encoding] = value
    return found


@pytest.fixture(scope="module")
def seed() -> str:
    return str(random.SystemRandom().randrange(1 << 30))


@pytest.fixture(scope="module")
def files(running_masters: Any, tmp_path_factory: pytest.TempPathFactory, seed: str) -> Path:
    folder = tmp_path_factory.mktemp("images") / "files"
    subprocess.run([STOCK_PYTHON, "-W", "ignore", PROGRAM, "make", folder, seed], check=True, capture_output=True)
    return folder


def overflows(stock: Images, name: str, encoding: str) -> bool:
    """Whether stock multiplies or cuts numbers of 16 bits as if they had 8."""
    image = stock[name, "passthrough"]
    return image is not None and image.dtype == np.uint16 and encoding in OVERFLOWING


@pytest.mark.parametrize("face", OURS)
def test_read_as_stock_does(master: Master, files: Path, seed: str, face: str) -> None:
    stock, ours = (read(each, master, files) for each in ("stock", face))
    assert stock.keys() == ours.keys() and len({name for name, _ in stock}) > 180
    wrong = []
    for key, wanted in stock.items():
        found = ours[key]
        if isinstance(wanted, str) or overflows(stock, *key):
            continue  # ours may do what stock refuses
        same = found is None if wanted is None else isinstance(found, np.ndarray) and found.dtype == wanted.dtype
        if not same or (wanted is not None and not np.array_equal(found, wanted)):
            wrong.append((key, getattr(wanted, "shape", wanted), getattr(found, "shape", found)))
    assert not wrong, f"{len(wrong)} with the seed {seed}: {wrong[:9]}"
    assert any(
        isinstance(image, np.ndarray) and image.dtype == np.uint16 and image.ndim == 3 for image in ours.values()
    )


@pytest.mark.parametrize("face", OURS)
def test_sixteen_bits_are_kept_in_encodings_with_sixteen_bits(
    master: Master, files: Path, seed: str, face: str
) -> None:
    ours = read(face, master, files)
    checked = 0
    for (name, encoding), image in ours.items():
        whole = ours[name, "passthrough"]
        if isinstance(whole, np.ndarray) and whole.dtype == np.uint16 and encoding == "bgr16":
            assert np.array_equal(image, whole), (name, seed)
            checked += 1
        elif isinstance(whole, np.ndarray) and whole.dtype == np.uint16 and encoding == "mono16" and whole.ndim == 2:
            assert np.array_equal(image, whole), (name, seed)
    assert checked > 30


@pytest.mark.parametrize("face", OURS)
def test_written_as_stock_does(master: Master, tmp_path: Path, seed: str, face: str) -> None:
    """Stock reads the same pixels from files that ours and stock have written."""
    run("stock", master, "write", str(tmp_path / "stock"), seed)
    run(face, master, "write", str(tmp_path / "ours"), seed)
    stock, ours = (read("stock", master, tmp_path / each) for each in ("stock", "ours"))
    wrong = []
    for (name, encoding), wanted in stock.items():
        if encoding != "passthrough" or (face == "ours" and needs_opencv(name)):
            continue
        found = ours.get((name, encoding))
        lossy = 2 if name.startswith("jp") else 0
        if not isinstance(found, np.ndarray) or found.dtype != wanted.dtype or found.shape != wanted.shape:
            wrong.append((name, wanted.shape, found if found is None else (found.dtype, found.shape)))
        elif np.abs(found.astype(float) - wanted).max(initial=0) > lossy:
            wrong.append((name, wanted.ravel()[:9], found.ravel()[:9]))
    assert not wrong, f"{len(wrong)} with the seed {seed}: {wrong[:9]}"
    assert ("png_u2_6x5x4", "passthrough") in ours and ("jpg_u1_1x5", "passthrough") in ours


@pytest.mark.parametrize("face", OURS)
def test_converted_as_stock_does(master: Master, seed: str, face: str) -> None:
    """From each encoding to each other; ours may do what stock refuses, or needs OpenCV for."""
    stock, ours = (run(each, master, seed, program=CONVERSIONS).splitlines() for each in ("stock", face))
    assert len(stock) == len(ours) > 4000
    may_refuse = face == "ours"
    wrong = [
        (wanted, found)
        for wanted, found in zip(stock, ours, strict=True)
        if wanted != found
        and not wanted.endswith(" error")
        and not (may_refuse and found.endswith(" error") and ("bayer" in found or "yuv" in found))
    ]
    assert not wrong, f"{len(wrong)} with the seed {seed}: {wrong[:5]}"


def needs_opencv(name: str) -> bool:
    """Whether Pillow cannot write such a file as OpenCV does."""
    form, kind, shape = name.split("_")
    colours = shape.count("x") == 2 and not shape.endswith("x1")
    if form == "tiff":
        if shape.endswith("x4"):
            return True  # Pillow says that it is opacity, by which OpenCV then multiplies the colours
        return kind not in ("u1", "u2", "i4", "f4") or (colours and kind != "u1")
    return form == "exr" or (form in ("pgm", "ppm") and kind != "u1")
