"""The lower libraries, genpy, genmsg, rosgraph, roslib, rospkg and those of images and clouds: as stock's.

Each program of ``programs/`` prints what the functions return and raise, for given and for random input.
"""

from __future__ import annotations

from pathlib import Path

import faces
import pytest
from harness import Master

MASTERS = ("ours",)
PROGRAMS = Path(__file__).parent / "programs"
SIGNATURES = """
import importlib, inspect
names = "{names}".split()
for name in names:
    module = importlib.import_module(name)
    homes = {{each.partition(".")[0] for each in names}} | {{"pyros1"}}
    for key, value in sorted(vars(module).items()):
        home = getattr(value, "__module__", None) or ""
        if key[0] == "_" or home.partition(".")[0] not in homes:
            continue
        members = [(key, value)]
        if inspect.isclass(value) and "pyros1" not in home and not issubclass(value, BaseException):
            members = [(key + "." + each, inner) for each, inner in sorted(vars(value).items()) if each[0] != "_"]
            members.append((key + ".__init__", value.__init__))
        for title, function in members:
            function = inspect.unwrap(getattr(function, "__func__", function))
            if inspect.isfunction(function):
                words = [each for each in inspect.signature(function).parameters]
                print(name, title, words)
"""
COMPARED = """
genpy.base genmsg.names genmsg.msgs genmsg.srvs genmsg.msg_loader genmsg.gentools roslib.packages
roslib.launcher rosgraph.masterapi rosgraph.names rosgraph.network rosgraph.rosenv rosgraph.xmlrpc
rosgraph.impl.graph rospkg.common rospkg.environment rospkg.manifest rospkg.rospack sensor_msgs.point_cloud2
cv_bridge.core image_geometry.cameramodels genpy.message genpy.dynamic
"""


NAMES = ["times", "messages", "cut_messages", "definitions", "clouds", "graph_network", "images", "cameras"]


@pytest.mark.parametrize("name", NAMES)
def test_the_same_as_stock(master: Master, name: str) -> None:
    assert faces.same(master, (PROGRAMS / f"{name}.py").read_text(), timeout=120, ROS_HOSTNAME=None)


def test_the_master(master: Master) -> None:
    assert faces.same(master, (PROGRAMS / "graph_master.py").read_text())


def test_parameters_have_stocks_names(master: Master) -> None:
    """All functions and methods that both have can be called with stock's names of parameters."""
    stock, ours = (
        dict(
            line.split(" [", 1)
            for line in faces.run(face, master, SIGNATURES.format(names=" ".join(COMPARED.split()))).splitlines()
        )
        for face in faces.FACES
    )
    assert len(stock) > 200
    wrong = {name: (ours[name], stock[name]) for name in stock.keys() & ours.keys() if ours[name] != stock[name]}
    assert not wrong
