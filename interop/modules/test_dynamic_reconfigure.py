"""dynamic_reconfigure: encoding, servers and clients on stock's modules and on ours, and in mixed pairs."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from faces import run, same, start
from harness import Master

MASTERS = ("ours",)  # they do not ask it
pytestmark = pytest.mark.ours_only

CFG = """
from dynamic_reconfigure.parameter_generator_catkin import *
from math import pi

gen = ParameterGenerator()
size = gen.enum(
    [gen.const("Small", int_t, 0, "A small one"), gen.const("Large", int_t, 2, "A large one")], "Which size"
)
gen.const("Word", str_t, "hello", "A word")
gen.add("int_", int_t, 1, "An integer", 5, -10, 10)
gen.add("size", int_t, 1, "A size", 0, 0, 3, edit_method=size)
gen.add("double_", double_t, 2, "A float", pi, -2, 10)
gen.add("free", double_t, 2, "A float without limits", 0.5)
gen.add("str_", str_t, 4, "A string", "foo")
gen.add("bool_", bool_t, 8, "A truth", True)
first = gen.add_group("First one")
first.add("inner", int_t, 16, "Deeper", 3)
second = first.add_group("Second", type="collapse", state=False)
second.add("word", str_t, 32, "Deeper still", "x")
third = gen.add_group("Third", type="tab")
third.add("last", bool_t, 0, "The last", False)

exit(gen.generate("conf_pkg", "conf_pkg", "Things"))
"""

# Stock has the module from a build; here its generator collects the same, and we write the module as the build would.
BUILD = """
import sys, runpy
from dynamic_reconfigure import parameter_generator_catkin as generator
def generate(self, package, node, name):
    self.pkgname, self.nodename, self.name = package, node, name
    parameters = self.group.get_parameters()
    print("inf = float('inf')")
    print("config_description =", repr(self.group.to_dict()))
    for key, field in (("min", "min"), ("max", "max"), ("defaults", "default"), ("level", "level"), ("type", "type")):
        print(key, "=", repr({each["name"]: each[field] for each in parameters}).replace(
            "'-std::numeric_limits<double>::infinity()'", "-inf").replace(
            "'std::numeric_limits<double>::infinity()'", "inf"))
    print("all_level =", sum(each["level"] for each in parameters if each["name"] not in ("size", "free")))
    for each in self.constants:
        print(f"{name}_{each['name']} =", repr(each["value"]))
    return 0
generator.ParameterGenerator.generate = generate
path, sys.argv = sys.argv[1], [sys.argv[1], "a", "b", "c", "d"]
runpy.run_path(path, run_name="__main__")
"""


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory, master: Master) -> Path:
    """A ROS package with a .cfg file, and a folder with the modules that stock needs for it."""
    root = tmp_path_factory.mktemp("conf")
    folder = root / "src" / "conf_pkg"
    (folder / "cfg").mkdir(parents=True)
    (folder / "package.xml").write_text(
        "<package><name>conf_pkg</name><version>1.0.0</version><description>d</description>"
        "<maintainer email='a@b.c'>m</maintainer><license>l</license></package>"
    )
    (folder / "cfg" / "Things.cfg").write_text(CFG)
    built = root / "built" / "conf_pkg" / "cfg"
    built.mkdir(parents=True)
    module = run("stock", master, BUILD, str(folder / "cfg" / "Things.cfg"))
    module = re.sub(r"'(min|max)': '(-?)std::[^']*'", r"'\1': \2inf", module)
    (built / "ThingsConfig.py").write_text(module)
    for each in (built, built.parent):
        (each / "__init__.py").write_text("")
    return root


def both(package: Path) -> dict[str, str]:
    """Environment in which both find the package: stock by PATH of built modules (see `HEAD`), ours by its folder."""
    return {"ROS_PACKAGE_PATH": str(package / "src"), "BUILT": str(package / "built")}


HEAD = """
import os, sys
if sys.executable == "/usr/bin/python3":
    sys.path.append(os.environ["BUILT"])
"""

MODULE = (
    HEAD
    + """
import ast
from conf_pkg.cfg import ThingsConfig as T
for name in ("min", "max", "defaults", "level", "type", "all_level", "Things_Small", "Things_Large", "Things_Word"):
    print(name, getattr(T, name))
def show(group, depth=0):
    print(depth, [(key, group[key]) for key in ("name", "type", "state", "id", "parent")])
    for each in group["parameters"]:
        print(sorted((k, v) for k, v in each.items() if k not in ("srcline", "srcfile", "edit_method")))
        if each["edit_method"]:
            parsed = ast.literal_eval(each["edit_method"])
            print(parsed["enum_description"])
            for choice in parsed["enum"]:
                print(sorted((k, v) for k, v in choice.items() if not k.startswith("src")))
    for each in group["groups"]:
        show(each, depth + 1)
show(T.config_description)
"""
)


def test_modules_from_cfg_files(master: Master, package: Path) -> None:
    assert "Deeper still" in same(master, MODULE, **both(package))


ENCODING = (
    HEAD
    + """
import copy, pickle
import dynamic_reconfigure
from dynamic_reconfigure import encoding
from dynamic_reconfigure.encoding import *
from conf_pkg.cfg import ThingsConfig as T
def show(value, depth=0):
    if isinstance(value, dict):
        print(" " * depth, type(value).__name__, len(value))
        for key in sorted(value):
            print(" " * depth, key)
            show(value[key], depth + 1)
    elif isinstance(value, list):
        for each in value:
            show(each, depth + 1)
    else:
        print(" " * depth, repr(value) if "srcline" not in str(value) else "enum")
def message(m):
    print([[(each.name, each.value) for each in getattr(m, kind)] for kind in ("bools", "ints", "strs", "doubles")])
    print(sorted((each.id, each.name, each.state, each.parent) for each in m.groups))
description = encode_description(T)
for each in (description.max, description.min, description.dflt):
    message(each)
for group in description.groups:
    print(group.name, group.type, group.id, group.parent)
    print([(p.name, p.type, p.level, p.description) for p in group.parameters])
tree = decode_description(description)
show(tree)
show(get_tree(description))
print([each["name"] for each in extract_params(T.config_description)], list(dynamic_reconfigure.get_parameter_names(T)))
values = encode_config(T.defaults)
message(values)
config = initial_config(values, T.config_description)
show(config)
show(initial_config(values))
encoded = encode_config(config)
message(encoded)
show(decode_config(encoded, tree))
show(decode_config(encoded))
show(group_dict(description.groups[1]))
print([(each.name, each.id, each.parent) for each in encode_groups(0, T.config_description)])
config = Config({"a": 1, "inner": Config({"b": 2})})
config.c = 3
print(config, config.a, config.inner.b, type(config.copy()).__name__, type(copy.deepcopy(config)).__name__)
print(pickle.loads(pickle.dumps(config)) == config, config.__getstate__())
del config["c"]
try:
    config.c
except KeyError:
    print("KeyError")
"""
)


def test_encoding(master: Master, package: Path) -> None:
    assert "Deeper still" in same(master, ENCODING, **both(package))


GENERATOR = """
from dynamic_reconfigure.parameter_generator_catkin import *
import sys
sys.argv[1:] = ["a", "b", "c", "d"]
gen = ParameterGenerator()
group = gen.add_group("Group")
print(int_t, str_t, double_t, bool_t, group.id, group.parent, group.name, group.state)
def attempt(call, *args, **options):
    try:
        print("ok", call(*args, **options) is None)
    except Exception as error:
        text = str(error) if "default" not in str(error) else ""
        print(isinstance(error, TypeError), isinstance(error, KeyError), text)
for call in (gen.add, group.add):
    attempt(call, "a", int_t, 0, "d", "x")
    attempt(call, "a b", int_t, 0, "d")
    attempt(call, "1a", int_t, 0, "d")
    attempt(call, "a", int_t, 0, "d", 5, 6, 9)
    attempt(call, "b", "foo", 0, "d")
    attempt(call, "c", double_t, 0, "d", 5, 1, 10)
    attempt(call, "c", double_t, 0, "d", "x")
    attempt(call, "d", str_t, 0, "d", 5)
    attempt(call, "e", bool_t, 0, "d", 1)
    attempt(call, "f", int_t, 0, "d", 5.5)
    attempt(call, "g", int_t, 0, "d", 5, None, "z")
    attempt(call, name="h", paramtype=int_t, level=0, description="d", default=5, min=0, max=9, edit_method="")
attempt(gen.const, "C", int_t, "x", "d")
attempt(gen.enum, [gen.const("A", int_t, 0, "d"), gen.const("B", str_t, "b", "d")], "en")
attempt(gen.enum, [], "en")
print([(each["name"], each["default"], each["min"], each["max"]) for each in group.get_parameters()])
print(gen.pytype("int"), gen.defval["double"], gen.maxval["int"], gen.minval["bool"], LINEDEBUG)
parameter = {"name": "p", "type": "double", "value": 5, "min": None}
for field in ("value", "min"):
    attempt(gen.check_type_fill_default, parameter, field, 2.0)
attempt(gen.check_type, parameter, "value")
gen.fill_type(parameter)
print(sorted(parameter.items()))
parameter["value"] = "x"
attempt(gen.check_type, parameter, "value")
for name in ("good", "0bad", "b ad", ""):
    try:
        print(check_name(name))
    except Exception as error:
        print(error)
for text in ("good", 'b"ad'):
    try:
        print(check_description(text))
    except Exception as error:
        print("refused")
"""


def test_the_generator(master: Master) -> None:
    assert "naming conventions" in same(master, GENERATOR)


SERVER = (
    HEAD
    + """
import rospy
from dynamic_reconfigure.server import Server
from dynamic_reconfigure import DynamicReconfigureCallbackException
from conf_pkg.cfg import ThingsConfig
for name in list(rospy.get_param("server", {})):
    rospy.delete_param("server/" + name)
rospy.set_param("server/int_", 500)
rospy.set_param("server/str_", "from the server")
rospy.init_node("server")
def change(config, level):
    print("callback", level, config.int_, config["double_"], config.str_, config.bool_, type(config).__name__)
    config.str_ = config.str_.upper()
    return config
server = Server(ThingsConfig, change)
print(server.ns, server.config.int_, rospy.get_param("~int_"), rospy.get_param("~str_"), rospy.get_param("~word"))
config = server.update_configuration({"int_": -500, "bool_": False})
print(config.int_, server.config["bool_"], rospy.get_param("~int_"))
other = Server(ThingsConfig, lambda config, level: config, namespace="deep")
print(other.ns, rospy.get_param("~deep/double_"), other.description == server.description)
picky = Server(ThingsConfig, lambda config, level: config if config.int_ != 7 else None, namespace="picky")
try:
    picky.update_configuration({"int_": 7})
except DynamicReconfigureCallbackException as error:
    print(error)
picky = Server(ThingsConfig, lambda config, level: config if config.int_ != 7 else None, namespace="picky2")
try:
    Server(ThingsConfig, lambda config, level: config, namespace="deep")
except rospy.ServiceException:
    print("ServiceException")
print("ready", flush=True)
rospy.spin()
"""
)
CLIENT = (
    HEAD
    + """
import rospy
import dynamic_reconfigure
from dynamic_reconfigure.client import Client
rospy.init_node("client", anonymous=True)
try:
    Client("/nowhere", timeout=0.2)
except rospy.ROSException as error:
    print(error)
def show(config):
    return [(key, config[key]) for key in sorted(config) if key != "groups"]
client = Client("/server", timeout=20)
first = client.get_configuration(timeout=0.0)
if "again" in sys.argv:  # as the one before began
    first = client.update_configuration(
        {"int_": 1, "size": 1, "double_": 1, "str_": "a", "bool_": True, "inner": 1, "word": "b"}
    )
print(client.name, show(first))
for each in client.get_parameter_descriptions(timeout=20):
    print(each["name"], each["type"], each["min"], each["max"], each["default"], each["level"])
print(client.get_group_descriptions()["groups"].keys())
for changes in (
    {"int_": 3}, {"int_": "5"}, {"double_": "2.5"}, {"double_": 500}, {"str_": 5}, {"bool_": "yes"}, {"bool_": "off"},
    {"size": "Large"}, {"size": "small"}, {"size": 77}, {}, {"int_": "x"}, {"zz": 1}, {"int_": 4, "zz": 1},
    {"word": "b\\u00e4", "inner": 9},
):
    try:
        print(show(client.update_configuration(dict(changes))))
    except dynamic_reconfigure.DynamicReconfigureParameterException as error:
        print(error)
print(client.get_configuration()["groups"]["groups"].keys())
def states(group):
    inner = group["groups"]
    return [(name, inner[name]["state"], states(inner[name])) for name in sorted(inner)]
for changes in ({"First_one": False}, {"Third": False, "First_one": True}, {"Default": False}, {"nope": True}, {}):
    print(changes, states(client.update_groups(changes)), states(client.get_group_descriptions()))
client.update_groups({"Third": True})
try:
    Client("/server/picky2", timeout=20).update_configuration({"int_": 7})
except dynamic_reconfigure.DynamicReconfigureCallbackException as error:
    print(error)
heard = []
other = Client("/server/deep", 20, lambda c: heard.append(("config", c.int_)), lambda d: heard.append(("d", len(d))))
while len(heard) < 2:
    rospy.sleep(0.01)
print(sorted(heard))
for number in (1, 5):
    other.update_configuration({"int_": number})
    while heard[-1] != ("config", number):
        rospy.sleep(0.01)
other.config_callback = None
other.description_callback = lambda d: print("described", len(d))
other.set_config_callback(lambda c: print("configured", c.int_))
print(other.get_config_callback() is other.config_callback)
other.config_callback = None
other.set_description_callback(None)
other.set_description_callback(lambda d: None)
print(other.config_callback, callable(other.get_description_callback()))
other.close()
print(dynamic_reconfigure.find_reconfigure_services())
"""
)


@pytest.mark.parametrize("server", ["stock", "ours"])
def test_servers_and_clients(master: Master, launcher: Master, package: Path, server: str) -> None:
    """Clients on both say the same of a server; and the servers print the same, see `expected`."""
    process = start(server, launcher, SERVER, **both(package))
    process.wait_line("^ready$")
    printed = [run(client, launcher, CLIENT, "again", **both(package)) for client in ("stock", "ours")]
    assert printed[0] == printed[1]
    assert "don't know parameter: zz" in printed[0]
    said = [line for line in process.lines if not line.startswith(("[", "the rosdep view"))]
    assert said[:8] == [
        "callback -1 10 3.141592653589793 from the server True Config",
        "~ 10 10 FROM THE SERVER x",
        "callback 9 -10 3.141592653589793 FROM THE SERVER False Config",
        "-10 False -10",
        "~deep/ 3.141592653589793 True",
        "Reconfigure callback should return a possibly updated configuration.",
        "ServiceException",
        "ready",
    ]


def test_our_servers_say_the_same_as_stocks(master: Master, launcher: Master, package: Path) -> None:
    """All that a stock client sees of a server on ours is what it sees of one on stock.

    Feature: dynamic_reconfigure servers and clients, with stock's on the other side; `.cfg` files need no
        build -- `pyros1.reconfigure`
    """
    seen = []
    for face in ("stock", "ours"):
        process = start(face, launcher, SERVER, **both(package))
        process.wait_line("^ready$")
        seen.append(run("stock", launcher, CLIENT, **both(package)))
        process.close()
    assert seen[0] == seen[1]
