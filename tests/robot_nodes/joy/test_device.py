"""Devices, and what they are asked when they are opened."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path
from queue import Queue
from typing import Any

import pytest

from pyros1.msgs.sensor_msgs.msg import Joy
from pyros1.robot_nodes.joy import device as device_module
from pyros1.robot_nodes.joy.device import Device
from pyros1.robot_nodes.joy.node import JoyNode

NAMES = {"js0": b"Pad", "js2": b"Wheel \xff", "js9": b"Pad", "js10": b"Pad"}


@pytest.fixture
def joysticks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Pipes that answer the requests of linux/joystick.h as joysticks with the names above do."""
    files = []
    for name in NAMES:
        os.mkfifo(tmp_path / name)
        files.append(os.open(tmp_path / name, os.O_RDWR))

    def ioctl(file: int, request: int, answer: bytearray) -> int:
        name = Path(os.readlink(f"/proc/self/fd/{file}")).name
        data = {0x80806A13: NAMES[name], 0x80016A11: b"\x06", 0x80016A12: b"\x0c"}[request]
        answer[: len(data)] = data
        return len(data)

    monkeypatch.setattr("fcntl.ioctl", ioctl)
    monkeypatch.setattr(device_module, "DEVICES", f"{tmp_path}/js*")
    yield tmp_path
    for file in files:
        os.close(file)


def test_name_and_sizes(joysticks: Path) -> None:
    device = Device(str(joysticks / "js2"))
    assert (device.name, device.axes, device.buttons) == ("Wheel \ufffd", 6, 12)
    device.close()


def test_finding_joysticks(joysticks: Path) -> None:
    (joysticks / "js1").write_text("no device")
    found = [(Path(path).name, name) for path, name in device_module.joysticks()]
    assert found == [("js0", "Pad"), ("js2", "Wheel \ufffd"), ("js9", "Pad"), ("js10", "Pad")]


def test_joy_node_finds_one_by_its_name(
    joysticks: Path, make_node: Callable[..., Any], wait_for_line: Callable[[str], None]
) -> None:
    came: Queue[Any] = Queue()
    make_node("user").subscribe("joy", Joy, came.put)
    JoyNode(make_node("stick", argv=["_dev_name:=Wheel \ufffd", "_autorepeat_rate:=100"]))
    message = came.get(timeout=20)
    assert (message.header.frame_id, len(message.axes), len(message.buttons)) == (f"{joysticks}/js2", 6, 12)
    JoyNode(make_node("other", argv=["_dev_name:=Stick", f"_dev:={joysticks}/none"]))
    wait_for_line("no joystick is called 'Stick' (there are: 'Pad', 'Wheel \ufffd', 'Pad', 'Pad'): using")


def test_reading(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "js0")
    device = Device(str(tmp_path / "js0"))
    assert (device.name, device.axes, device.buttons) == ("", 0, 0)
    with open(tmp_path / "js0", "wb") as joystick:
        assert device.read() == b""
        joystick.write(b"12345678")
        joystick.flush()
        assert device.read() == b"12345678"
    with pytest.raises(OSError, match="it was closed"):
        device.read()
    device.close()


def test_what_is_no_device(tmp_path: Path) -> None:
    (tmp_path / "js0").write_bytes(bytes(8))
    for path in (tmp_path / "js0", tmp_path):
        with pytest.raises(OSError, match="it is no device"):
            Device(str(path))
