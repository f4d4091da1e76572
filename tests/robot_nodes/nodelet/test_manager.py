from __future__ import annotations

from collections.abc import Callable
from time import monotonic
from typing import Any

import pytest

from pyros1.msgs.nodelet.srv import NodeletList, NodeletLoad, NodeletUnload
from pyros1.node import Node
from pyros1.robot_nodes.nodelet.manager import Manager

PATIENCE = 20.0


def test_services(make_node: Callable[..., Node], capfd: pytest.CaptureFixture[str]) -> None:
    Manager(make_node("camera_manager"))
    user = make_node("user")

    def call(name: str, cls: Any, /, **fields: Any) -> Any:
        with user.service(f"/camera_manager/{name}", cls) as client:
            return client.call(cls._request_class(**fields), PATIENCE)

    assert call("load_nodelet", NodeletLoad, name="crop", type="image_proc/crop").success is False
    assert call("unload_nodelet", NodeletUnload, name="crop").success is False
    assert [*call("list", NodeletList).nodelets] == []
    text, deadline = "", monotonic() + PATIENCE
    while "cannot load the nodelet crop of the class image_proc/crop" not in text and monotonic() < deadline:
        text += capfd.readouterr().err
    assert text.count("\n") == 1
