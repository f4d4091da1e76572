"""Debian's rviz on a screen of its own: tests load displays into it and look at its picture."""

from __future__ import annotations

import os
import shutil
import subprocess
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from xmlrpc.client import ServerProxy

import numpy as np
from numpy.typing import NDArray
from raw import connect, encode_header, read_exactly, read_header

Picture = NDArray[np.uint8]
"""Rows of pixels, from the top: red, green, blue."""
WIDTH, HEIGHT = 768, 508
"""Pixels of the 3D view in rviz's window if that has no panels."""
_LEFT, _TOP = 16, 62
PATIENCE = 30.0
WINDOW = {"Height": 600, "Width": 800, "X": 0, "Y": 0, "Hide Left Dock": True, "Hide Right Dock": True}
"""The entry ``Window Geometry`` of a file that gives the view this size."""


def is_here() -> bool:
    """Return whether this machine has rviz and a screen for it."""
    return bool(shutil.which("rviz") and shutil.which("Xvfb"))


class Rviz:
    """A running rviz."""

    def __init__(self, master: str, screen: Path) -> None:
        self._master = master
        self._screen = screen

    def load(self, file: Path) -> None:
        """Show the displays of a file."""
        self._ask("load_config_discarding_changes", file)

    def save(self, file: Path) -> None:
        """Write what is shown now into a file."""
        self._ask("save_config", file)

    def picture(self) -> Picture:
        """Return the 3D view as it is now."""
        data = (
            self._screen.read_bytes()
        )  # X's window dump: a header, a table of colours, and rows of blue, green, red, 0
        numbers = np.frombuffer(data[:100], ">u4")
        start, row = int(numbers[0]) + 12 * int(numbers[19]), int(numbers[12])
        rows = np.frombuffer(data, np.uint8, row * int(numbers[5]), start).reshape(-1, row // 4, 4)
        return rows[_TOP : _TOP + HEIGHT, _LEFT : _LEFT + WIDTH, 2::-1]

    def is_ready(self) -> bool:
        """Return whether it answers."""
        return bool(self._lookup("load_config_discarding_changes"))

    def _lookup(self, service: str) -> str:
        with ServerProxy(self._master) as master:
            code, _, uri = master.lookupService("/test", f"/rviz/{service}")
        return str(uri) if code == 1 else ""

    def _ask(self, service: str, file: Path) -> None:
        """Call a service of rviz/SendFilePath: a string, answered with a bool."""
        host, port = self._lookup(service).removeprefix("rosrpc://").split(":")
        text = str(file).encode()
        request = len(text).to_bytes(4, "little") + text
        with connect(host, int(port)) as connection:
            connection.sendall(encode_header({"callerid": "/test", "service": f"/rviz/{service}", "md5sum": "*"}))
            read_header(connection)
            connection.sendall(len(request).to_bytes(4, "little") + request)
            assert read_exactly(connection, 6) == b"\1\1\0\0\0\1", f"rviz did not {service} {file}"


@contextmanager
def start_rviz(environ: Mapping[str, str], folder: Path) -> Iterator[Rviz]:
    """Run rviz without a graphics card until the context ends.

    Args:
        environ: the environment variables of ROS.
        folder: for its files.
    """
    reading, writing = os.pipe()
    words = [
        "-displayfd",
        str(writing),
        "-screen",
        "0",
        "800x600x24",
        "-fbdir",
        str(folder),
        "-nolisten",
        "tcp",
        "-nocursor",
    ]
    screen = subprocess.Popen(
        ["Xvfb", *words], pass_fds=[writing], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    os.close(writing)
    with os.fdopen(reading) as file:
        display = file.readline().strip()  # it is ready, or has ended
    empty = folder / "empty.rviz"
    empty.write_text("Visualization Manager: {}\n")
    runtime = folder / "runtime"
    runtime.mkdir(mode=0o700, exist_ok=True)
    more = {
        "DISPLAY": f":{display}",
        "LIBGL_ALWAYS_SOFTWARE": "1",
        "HOME": str(folder),
        "XDG_RUNTIME_DIR": str(runtime),
    }
    program = None
    try:
        assert display, "Xvfb does not start"
        with (folder / "rviz.log").open("wb") as log:
            program = subprocess.Popen(
                ["rviz", "-d", str(empty), "-s", "none", "__name:=rviz"],
                env={**os.environ, **environ, **more},
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
            )
        rviz = Rviz(environ["ROS_MASTER_URI"], folder / "Xvfb_screen0")
        until = time.monotonic() + PATIENCE
        while not rviz.is_ready():
            assert program.poll() is None and time.monotonic() < until, (folder / "rviz.log").read_text()
            time.sleep(0.05)
        yield rviz
    finally:
        for process in (program, screen):
            if process is not None:
                process.terminate()
        for process in (program, screen):
            if process is not None:
                try:
                    process.wait(10)
                except subprocess.TimeoutExpired:
                    process.kill()
                    process.wait()
