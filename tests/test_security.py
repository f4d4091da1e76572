"""Nothing that was received is run: what could do so is listed here, with its reason. The table of known attacks."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
SOURCE = ROOT / "src" / "pyros1"
TABLE = ROOT / "interop" / "security.md"

DANGEROUS = {"eval", "exec", "compile", "__import__", "getoutput", "getstatusoutput", "create_subprocess_shell"}
"""Functions that run text or lead to it, whatever module they are of."""
OF_MODULES = {
    "os": {"system", "popen"},
    "pickle": {"load", "loads", "Unpickler"},
    "marshal": {"load", "loads"},
    "shelve": {"open"},
    "yaml": {"unsafe_load", "unsafe_load_all", "full_load", "full_load_all", "Loader", "UnsafeLoader", "FullLoader"},
}
PARSERS = {"xml.etree.ElementTree", "xml.dom.minidom", "xml.dom.pulldom", "xml.sax", "xml.parsers.expat", "xmlrpc"}
"""Modules whose parsers expand entities: defusedxml's are used."""
HARMLESS = {"Element", "SubElement", "ElementTree", "ParseError", "ExpatError", "tostring", "escape", "quoteattr"}
HARMLESS |= {"Binary", "Fault"}  # of xmlrpc

ALLOWED = {
    "ground/lazy.py: __import__": "modules of pyros1, by names in the source",
    "msgs/generator.py: compile": "codecs, made of checked field names; random definitions are tested",
    "msgs/generator.py: exec": "the same",
    "bag/edit/migration.py: compile": "rule files that the user names: Python, as stock's",
    "bag/edit/migration.py: exec": "the same",
    "launch/remote/agent.py: exec": "a part of pyros1 that the launcher sends over its own SSH connection",
    "launch/running/fork_server.py: compile": "a launch's own nodes, in place of their interpreter",
    "launch/running/fork_server.py: __import__": "modules named in the source",
    "drop_in/configs.py: compile": "a package's .cfg files: Python, as stock's",
    "drop_in/configs.py: exec": "the same",
    "drop_in/modules/rosparam/__init__.py: yaml.Loader": "gets a constructor for angles",
    "drop_in/modules/rosparam/__init__.py: yaml.FullLoader": "the same",
    "drop_in/modules/smach_ros/local_data.py: pickle.Unpickler": "plain values only, after a check",
    "drop_in/modules/rosgraph/xmlrpc.py: from xmlrpc.server": "programs get Python's, as from stock",
    "drop_in/modules/roslaunch/core.py: from xmlrpc.client": "the same",
    "drop_in/modules/roslaunch/netapi.py: from xmlrpc.client": "the same",
    "drop_in/modules/roslib/scriptutil.py: from xmlrpc.client": "the same",
    "drop_in/modules/rospy/core.py: from xmlrpc.client": "the same",
    "drop_in/modules/rostest/__init__.py: from xmlrpc.client": "the same",
}


WORDS = re.compile(
    rf"(?<!re\.)\b(?:{'|'.join(DANGEROUS)})\(|shell=|\bos\.(?:system|popen)|\b(?:pickle|marshal|shelve|yaml|xml|xmlrpc)\b"
)
"""One of these is in each file with anything dangerous; the others need not be parsed."""


def sources() -> list[tuple[str, str]]:
    """Return names and texts of the source files that may have anything dangerous."""
    found = [(str(path.relative_to(SOURCE)), path.read_text(encoding="utf-8")) for path in sorted(SOURCE.rglob("*.py"))]
    return [(name, text) for name, text in found if WORDS.search(text)]


def danger(node: ast.AST) -> str:  # noqa: PLR0911 - one return per kind
    """Return what is dangerous in a piece of a program; empty for nothing."""
    match node:
        case ast.Call(func=ast.Name(id=name)) if name in DANGEROUS:
            return name
        case ast.Call(func=ast.Attribute(attr=name)) if name in DANGEROUS - {"compile"}:  # re.compile is harmless
            return name
        case ast.keyword(arg="shell", value=value) if not (isinstance(value, ast.Constant) and not value.value):
            return "shell"
        case ast.Attribute(value=ast.Name(id=module), attr=name) if name in OF_MODULES.get(module, ()):
            return f"{module}.{name}"
        case ast.Call(func=ast.Attribute(value=ast.Name(id="yaml"), attr="load" | "load_all"), args=args):
            return "" if len(args) == 2 and ast.unparse(args[1]) == "yaml.SafeLoader" else "yaml.load"
        case ast.ImportFrom(module=str(module), names=names):
            found = {each.name for each in names}
            if any(module == parser or module.startswith(f"{parser}.") for parser in PARSERS):
                return f"from {module}" if found - HARMLESS else ""
            return f"from {module}" if found & OF_MODULES.get(module, set()) else ""
        case ast.Import(names=names):
            return next((f"import {each.name}" for each in names if each.name.split(".")[0] in ("xml", "xmlrpc")), "")
    return ""


def test_nothing_in_the_source_can_run_what_was_received() -> None:
    found = set()
    for name, text in sources():
        for node in ast.walk(ast.parse(text)):
            if what := danger(node):
                found.add(f"{name}: {what}")
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
    ],
)
def test_the_search_finds(text: str) -> None:
    assert any(danger(node) for node in ast.walk(ast.parse(text)))


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
