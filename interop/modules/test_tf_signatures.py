"""The functions and methods of tf's modules take the same arguments in stock's and ours, and none is missing."""

from __future__ import annotations

import json

from faces import run
from harness import Master

MASTERS = ("ours",)  # these programs need no master; the fixture gives their environment

PROGRAM = """
import importlib, inspect, json
found = {}
for module in ("tf2_ros", "tf2_ros.buffer", "tf2_ros.buffer_client", "tf2_ros.buffer_interface",
               "tf2_ros.transform_listener", "tf2_ros.transform_broadcaster", "tf2_ros.static_transform_broadcaster",
               "tf", "tf.broadcaster", "tf.listener", "tf.transformations", "tf2_py", "tf2_geometry_msgs",
               "tf2_geometry_msgs.tf2_geometry_msgs", "tf2_sensor_msgs.tf2_sensor_msgs",
               "laser_geometry.laser_geometry", "interactive_markers.menu_handler",
               "interactive_markers.interactive_marker_server"):
    it = importlib.import_module(module)
    for name in dir(it):
        value = getattr(it, name)
        home = str(getattr(value, "__module__", ""))
        if name.startswith("_") or inspect.ismodule(value) or home == "__future__" or home == "copy" or name == "Lock":
            continue
        own = inspect.isclass(value) and not issubclass(value, Exception) and not hasattr(value, "_slot_types")
        things = {name: value}
        if own:
            things.update({name + "." + part: getattr(value, part) for part in dir(value) if not part.startswith("_")})
            things[name + ".__init__"] = value
        for label, thing in things.items():
            try:
                parameters = inspect.signature(thing).parameters.values()
            except (TypeError, ValueError):
                parameters = None
            # a C function tells nothing; classes are judged by __init__
            if parameters is None or inspect.isclass(thing) and not label.endswith("__init__"):
                found[module + ":" + label] = None
            else:
                found[module + ":" + label] = [[p.name, str(p.kind), p.default is p.empty] for p in parameters]
print(json.dumps(found))
"""


def test_names_and_arguments(master: Master) -> None:
    stock, ours = (json.loads(run(face, master, PROGRAM).splitlines()[-1]) for face in ("stock", "ours"))
    late = (":read_points", ":create_cloud")  # they are imported when they are first used
    stock = {name: arguments for name, arguments in stock.items() if not name.endswith(late)}
    assert not sorted(stock.keys() - ours.keys())
    assert len(stock) > 250
    told = {name: arguments for name, arguments in stock.items() if arguments is not None}
    assert not {name: (arguments, ours[name]) for name, arguments in told.items() if ours[name] != arguments}
