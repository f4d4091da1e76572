"""Nothing that was received is run: what could do so is listed here, with its reason. The table of known attacks."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

pytestmark = pytest.mark.once

ROOT = Path(__file__).resolve().parents[1]
SOURCE = ROOT / "src" / "pyros1"
TABLE = ROOT / "interop" / "security.md"

DANGEROUS = {"eval", "exec", "compile", "__import__", "getoutput", "getstatusoutput", "create_subprocess_shell"}
"""Functions that run text or lead to it, whatever module they are of."""
OF_MODULES = {
    "os": r"system|popen|(?:exec|spawn)[lv]\w*|posix_spawnp?",
    "pickle": r"loads?|(?:_?)Unpickler",
    "marshal": r"loads?",
    "shelve": r"open|\w*Shelf",
    "runpy": r"run_\w+",
    "code": r"interact|Interactive\w+",
    "yaml": r"(?:unsafe|full)_load(?:_all)?|(?:Unsafe|Full|C|CFull|CUnsafe)?Loader",
}
"""Patterns of names that are as dangerous."""
PARSERS = {"xml.etree.ElementTree", "xml.dom.minidom", "xml.dom.pulldom", "xml.sax", "xml.parsers.expat", "xmlrpc"}
"""Modules whose parsers expand entities: defusedxml's are used."""
HARMLESS = {"Element", "SubElement", "ElementTree", "ParseError", "ExpatError", "tostring", "escape", "quoteattr"}
HARMLESS |= {"Binary", "Fault"}  # of xmlrpc

ALLOWED = {
    "ground/lazy.py: __import__": "modules of pyros1, by names in the source",
    "msgs/generator.py: compile": "codecs, made of checked field names; random definitions are tested",
    "msgs/generator.py: exec": "the same",
    "ros2_types/transcoding/source.py: compile": "conversions, made of positions and sizes; random types are tested",
    "ros2_types/transcoding/source.py: exec": "the same",
    "bag/edit/migration.py: compile": "rule files that the user names: Python, as stock's",
    "bag/edit/migration.py: exec": "the same",
    "launch/remote/agent.py: exec": "a part of pyros1 that the launcher sends over its own SSH connection",
    "launch/preload/server.py: compile": "a launch's own nodes, in place of their interpreter",
    "launch/preload/server.py: __import__": "modules named in the source",
    "drop_in/cfg_modules.py: compile": "a package's .cfg files: Python, as stock's",
    "drop_in/cfg_modules.py: exec": "the same",
    "cli/commands/run.py: os.execvpe": "the program that the user names, with its words one by one",
    "cli/package_scripts.py: importlib.import_module": "modules of pyros1, named in the table of that file",
    "cli/make_index.py: os.execv": "this program itself, when pyros1 is built",
    "cli/registry.py: importlib.import_module": "commands by names in the registry",
    "web/calls/__init__.py: importlib.import_module": "files of a fixed list; the page's request must name one of them",
    "web/views/__init__.py: importlib.import_module": "the same, of the views",
    "web/rosbridge/rosapi/__init__.py: importlib.import_module": "names in the source",
    "bag/export/extras.py: importlib.import_module": "the same",
    "bag/export/mcap_reader.py: importlib.import_module": "the same",
    "bridge/transport/certificates.py: importlib.import_module": "the same",
    "robot_nodes/diagnostic_aggregator/match_ways.py: importlib.import_module": "the same",
    "launch/remote/agent.py: importlib.import_module": "the same",
    "ros2/rclpy_side/type_classes.py: importlib.import_module": "installed ROS 2 packages that define the type",
    "drop_in/module_attributes.py: importlib.import_module": "the same",
    "drop_in/message_modules.py: importlib.import_module": "packages that the program itself imports",
    "drop_in/start/pyros1_modules.py: __import__": "the module that the program itself imports, from behind ours",
    "launch/reading/xacro_tool.py: import xml.parsers.expat": "xacro names its errors; it parses the user's own file",
    "drop_in/modules/genpy/message.py: importlib.import_module": "modules `PACKAGE.msg`, of checked names, as stock's",
    "msgs/genpy_classes.py: importlib.import_module": "the same, of definitions of the program's own classes",
    "finding/importing.py: importlib.import_module": "pyros1's own modules of messages, of packages that are found",
    "cli/commands/topic_tools/_expression.py: importlib.import_module": "the same",
    "drop_in/modules/rosparam/__init__.py: yaml.Loader": "gets a constructor for angles",
    "drop_in/modules/rosparam/__init__.py: yaml.FullLoader": "the same",
    "drop_in/modules/smach_ros/local_data.py: pickle.Unpickler": "plain values only, after a check",
    "drop_in/modules/rosgraph/xmlrpc.py: from xmlrpc.server": "programs get Python's, as from stock",
    "drop_in/modules/roslaunch/core.py: from xmlrpc.client": "the same",
    "drop_in/modules/roslaunch/netapi.py: from xmlrpc.client": "the same",
    "drop_in/modules/roslib/scriptutil.py: from xmlrpc.client": "the same",
    "drop_in/modules/rospy/core.py: from xmlrpc.client": "the same",
    "drop_in/modules/rospy/msproxy.py: from xmlrpc.client": "the same",
    "drop_in/modules/rostest/__init__.py: from xmlrpc.client": "the same",
}


WORDS = re.compile(
    rf"(?<!re\.)\b(?:{'|'.join(DANGEROUS)})\(|shell=|allow_pickle|import_module|\b(?:exec|spawn)[lv]|\bfrom os import"
    r"|\bimport os as|\bos\.(?:system|popen|posix)|[\"'](?:system|popen)[\"']"
    r"|\b(?:_?pickle|marshal|shelve|yaml|xml|xmlrpc|runpy|code|builtins) ?(?:\.|$| )"
)
"""One of these is in each file with anything dangerous; the others need not be parsed."""
PAGE = SOURCE / "web" / "page"
IN_PAGES = re.compile(
    r"\beval\b|\bFunction\s*\(|\b(?:inner|outer)HTML\b|insertAdjacentHTML|document\.write|createContextualFragment|srcdoc"
    r"|set(?:Timeout|Interval)\(\s*[\"'`]|javascript:"
)
"""What makes program or page of text in a browser."""


def sources() -> list[tuple[str, str]]:
    """Return names and texts of the source files that may have anything dangerous."""
    found = [(str(path.relative_to(SOURCE)), path.read_text(encoding="utf-8")) for path in sorted(SOURCE.rglob("*.py"))]
    return [(name, text) for name, text in found if WORDS.search(text)]


def meanings(tree: ast.AST) -> dict[str, str]:
    """Return what the names mean that a program imports, such as ``{"p": "pickle", "load": "yaml.load"}``."""
    found = {}
    for node in ast.walk(tree):
        match node:
            case ast.Import(names=names):
                found.update({each.asname: each.name for each in names if each.asname})
            case ast.ImportFrom(module=str(module), names=names, level=0):
                found.update({each.asname or each.name: f"{module}.{each.name}" for each in names})
    return found


def meant(node: ast.AST, known: dict[str, str]) -> str:
    """Return the whole name of what a name or attribute means; empty for other pieces of a program."""
    match node:
        case ast.Name(id=name):
            return known.get(name, name)
        case ast.Attribute(value=value, attr=name) if base := meant(value, known):
            return f"{base}.{name}"
        case ast.Call(func=ast.Name(id="getattr"), args=[value, ast.Constant(value=str(name)), *_]):
            return f"{meant(value, known)}.{name}"
    return ""


def danger(node: ast.AST, known: dict[str, str]) -> str:  # noqa: PLR0911 - one return per kind
    """Return what is dangerous in a piece of a program; empty for nothing.

    Args:
        node: the piece.
        known: the meanings of names in the program.
    """
    whole = meant(node, known)
    module, _, name = whole.rpartition(".")
    if re.fullmatch(OF_MODULES.get(module.removeprefix("_"), "(?!)"), name):
        return whole
    if module == "builtins" and name in DANGEROUS:
        return name
    match node:
        case ast.Call(func=ast.Name(id=name)) if name in DANGEROUS:
            return name
        case ast.Call(func=ast.Attribute(attr=name)) if name in DANGEROUS - {"compile"}:  # re.compile is harmless
            return name
        case ast.keyword(arg="shell" | "allow_pickle" as name, value=value):
            return "" if isinstance(value, ast.Constant) and not value.value else name
        case ast.Call(func=func, args=args) if (whole := meant(func, known)) in ("yaml.load", "yaml.load_all"):
            safe = len(args) == 2 and meant(args[1], known) in ("yaml.SafeLoader", "yaml.CSafeLoader")
            return "" if safe else "yaml.load"
        case ast.Call(func=func, args=args) if (whole := meant(func, known)) == "importlib.import_module":
            return "" if args and isinstance(args[0], ast.Constant) else whole
        case ast.ImportFrom(module=str(module), names=names):
            found = {each.name for each in names}
            if any(module == parser or module.startswith(f"{parser}.") for parser in PARSERS):
                return f"from {module}" if found - HARMLESS else ""
            pattern = OF_MODULES.get(module.removeprefix("_"), "(?!)")
            return f"from {module}" if any(re.fullmatch(pattern, name) for name in found) else ""
        case ast.Import(names=names):
            return next((f"import {each.name}" for each in names if each.name.split(".")[0] in ("xml", "xmlrpc")), "")
    return ""


def dangers(text: str) -> set[str]:
    """Return what is dangerous in a program."""
    tree = ast.parse(text)
    known = meanings(tree)
    return {what for node in ast.walk(tree) if (what := danger(node, known))}


@pytest.mark.slow
def test_nothing_in_the_source_can_run_what_was_received() -> None:
    found = {f"{name}: {what}" for name, text in sources() for what in dangers(text)}
    assert found == ALLOWED.keys()


@pytest.mark.parametrize(
    "text",
    [
        "eval(x)",
        "exec(x)",
        "builtins.eval(x)",
        "os.system(x)",
        "subprocess.run(x, shell=True)",
        "subprocess.run(x, shell=y)",
        "subprocess.getoutput(x)",
        "pickle.loads(x)",
        "from pickle import loads",
        "yaml.load(x)",
        "yaml.load(x, Loader)",
        "yaml.unsafe_load(x)",
        "import xml.etree.ElementTree as tree",
        "from xml.dom.minidom import parseString",
        "from xmlrpc.client import ServerProxy",
        "import pickle as p; p.loads(x)",
        "from _pickle import loads as read; read(x)",
        "import yaml as y; y.load(x)",
        "from yaml import load as l; l(x)",
        "from yaml import load; load(x, Loader=y)",
        "from yaml import FullLoader as L",
        "import numpy; numpy.load(x, allow_pickle=True)",
        "from numpy import load as l; l(x, allow_pickle=y)",
        "os.execv(x, y)",
        "os.execvpe(x, y, z)",
        "os.spawnlp(os.P_WAIT, x)",
        "os.posix_spawn(x, y, z)",
        "os.popen(x)",
        "import os as o; o.system(x)",
        "from os import system as s; s(x)",
        "run = os.system",
        "getattr(os, 'system')(x)",
        "import builtins as b; b.exec(x)",
        "from builtins import eval as e; e(x)",
        "import importlib; importlib.import_module(x)",
        "from importlib import import_module as i; i(f'{x}.y')",
        "import runpy as r; r.run_path(x)",
    ],
)
def test_the_search_finds(text: str) -> None:
    assert dangers(text) and WORDS.search(text)


@pytest.mark.parametrize(
    "text",
    [
        "re.compile(x)",
        "subprocess.run(x, shell=False)",
        "yaml.load(x, yaml.SafeLoader)",
        "from yaml import load as l, SafeLoader as S; l(x, S)",
        "importlib.import_module('numpy')",
        "numpy.load(x, allow_pickle=False)",
        "self.load(x)",
        "os.path.join(x)",
    ],
)
def test_the_search_leaves_alone(text: str) -> None:
    assert not dangers(text)


def test_nothing_in_the_pages_makes_program_or_page_of_text() -> None:
    files = [path for path in PAGE.rglob("*") if path.suffix in (".js", ".html")]
    own = [path for path in files if "vendor" not in path.relative_to(PAGE).parts]
    assert len(own) > 50
    found = [f"{path}: {match[0]}" for path in own for match in IN_PAGES.finditer(path.read_text(encoding="utf-8"))]
    assert not found


@pytest.mark.parametrize(
    "text",
    [
        "eval(x)",
        "window.eval(x)",
        "new Function(x)",
        "a.innerHTML = x",
        "a.outerHTML = x",
        "a.insertAdjacentHTML(b, x)",
        "document.write(x)",
        "setTimeout('x', 5)",
    ],
)
def test_the_search_finds_in_pages(text: str) -> None:
    assert IN_PAGES.search(text)


def rows() -> list[tuple[str, str]]:
    """Return the rows of the table: what it is about, and the tests."""
    lines = TABLE.read_text(encoding="utf-8").splitlines()
    cells = [[cell.strip() for cell in line.split("|")[1:-1]] for line in lines if line.startswith("| ")]
    return [(row[0], row[-1]) for row in cells if row[0] not in ("CVE", "attack", "---")]


@pytest.mark.parametrize(("attack", "tests"), rows())
def test_each_known_attack_is_tested(attack: str, tests: str) -> None:
    named = re.findall(r"`((?:tests|interop)/[^`:]+)(?:::(\w+))?`", tests)
    assert named or tests.startswith("none: "), attack
    for file, name in named:
        text = (ROOT / file).read_text(encoding="utf-8")
        assert not name or re.search(rf"def {name}\b", text), f"{attack}: no {name} in {file}"


def test_the_table_has_the_known_vulnerabilities() -> None:
    found = {number for attack, _ in rows() for number in re.findall(r"CVE-\d{4}-\d+", attack)}
    assert len(found) >= 10
