"""dynparam beside ours (L200), and the table of all commands, `commands.md`.

rosdiagnostic (L202) is not among Debian's packages, so
`tests/cli/commands/test_diagnostic.py` has to say what is expected.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from harness import INTEROP, ForkedTools, Master, our_tools, stock_tools
from named_tools import named_tool

import pyros1

MASTERS = ("ours",)  # stock's tools and ours are compared, whatever the master

pytestmark = pytest.mark.ours_only

Answer = tuple[int, str, str]

# dynparam -------------------------------------------------------------------------------------------------------------

DYNPARAM = "/usr/lib/dynamic_reconfigure/dynparam"
STOCK_SERVER = """
import rospy
from dynamic_reconfigure.cfg import TestConfig
from dynamic_reconfigure.server import Server
rospy.init_node("theirs")
servers = [Server(TestConfig, lambda config, level: config, namespace=name) for name in "ab"]
print("ready", flush=True)
rospy.spin()
"""
COMMANDS = """
set NODE {int_:\u00a03,\u00a0str_:\u00a0x,\u00a0bool_:\u00a0no,\u00a0double_:\u00a07,\u00a0mstr_:\u00a017}
set NODE int_ -500
set NODE double_ -1e0
set NODE str_ a:\u00a0b\u00a0\u00fc
set NODE bool_ true
set NODE int_enum_ medium
get NODE
set NODE int_ 1.5
set NODE itn_ 5
set NODE 5
set NODE
set NODE a b c
set -t0.1 /nowhere int_ 5
get -t 0.1 /nowhere
get -t x NODE
get NODE more
get
dump NODE FILE
dump NODE
load NODE PLAIN
load NODE nofile
set_from_parameters NODE _int_:=4 _str_:=seven _bool_:=false _double_:=2.5
set_from_parameters NODE
set_from_parameters
get NODE
""".strip().split("\n")
SHORT = """
set NODE {int_:\u00a03,\u00a0str_:\u00a0x,\u00a0bool_:\u00a0yes,\u00a0double_:\u00a07}
set NODE {groups:\u00a0{GROUP2:\u00a0true}}
dump NODE FILE
set NODE int_ 500
load NODE FILE
set NODE {groups:\u00a0{Group_One:\u00a0false}}
get NODE
""".strip().split("\n")


@pytest.fixture(scope="module")
def nodes(master: Master) -> Iterator[None]:
    """A stock node and one of ours, each with two sets of parameters of the same kinds."""
    process = master.run(["/usr/bin/python3", "-c", STOCK_SERVER])
    process.wait_line("^ready$")
    with pyros1.Node("mine", argv=[], environ=master.environ(), rosout=False, handle_signals=False) as node:
        for space in "ab":
            serve(node, f"/theirs/{space}", f"~{space}")
        yield
    process.close()


def serve(node: pyros1.Node, original: str, space: str) -> None:
    """Offer parameters as another node describes them."""
    description: Any = node.wait_for_message(
        f"{original}/parameter_descriptions", "dynamic_reconfigure/ConfigDescription"
    )
    config: Any = node.wait_for_message(f"{original}/parameter_updates", "dynamic_reconfigure/Config")

    def change(request: Any) -> tuple[Any]:
        for field in config.__slots__:
            wanted = {each.name: each for each in getattr(request.config, field)}
            setattr(config, field, [wanted.get(each.name, each) for each in getattr(config, field)])
        config.ints = [type(each)(each.name, max(-10, min(each.value, 10))) for each in config.ints]
        updates.publish(config)
        return (config,)

    node.advertise(f"{space}/parameter_descriptions", type(description), latch=True).publish(description)
    updates = node.advertise(f"{space}/parameter_updates", type(config), latch=True)
    updates.publish(config)
    node.advertise_service(f"{space}/set_parameters", "dynamic_reconfigure/Reconfigure", change)


def ask(tools: ForkedTools, words: list[str], environ: dict[str, str]) -> tuple[int, str, bool]:
    """Exit code, output, and whether it complained."""
    code, out, err = tools.ask(words, environ)
    # Where rosdep is installed but was never set up, a machine is slow, or ours has a hint.
    err = re.sub(r"^(the rosdep view is empty: |Waiting for |dynparam: ).*\n", "", err, flags=re.MULTILINE)
    return code, out, bool(err)


@pytest.mark.parametrize(("server", "lines"), [("/theirs", COMMANDS), ("/mine", SHORT)], ids=["stock", "ours"])
def test_dynparam_l200(master: Master, nodes: None, tmp_path: Path, server: str, lines: list[str]) -> None:
    """One command after the other, by either tool; a node that is not there is a traceback in stock.

    Feature: dynamic_reconfigure: list, get, set, load, dump -- `pyros1 dynparam`
    """
    ours = named_tool(tmp_path, "dynparam")
    (tmp_path / "plain.yaml").write_text("int_: 2\n---\n{str_: 'plain', double_: 3}\n")

    def talk(program: str, node: str) -> list[object]:
        tools = stock_tools() if program == DYNPARAM else our_tools()
        file = tmp_path / f"file{node[-1]}"
        names = {"NODE": node, "FILE": str(file), "PLAIN": str(tmp_path / "plain.yaml")}
        answers: list[object] = []
        for line in lines:
            words = [names.get(word, word).replace("\u00a0", " ") for word in line.split(" ")]
            code, out, complains = ask(tools, [program, *words], master.environ())
            answers.append((line, code, out.replace(node, "NODE"), complains))
        return [*answers, file.read_text()]

    with ThreadPoolExecutor(2) as pool:
        stock, mine = pool.map(talk, [DYNPARAM, ours], [f"{server}/a", f"{server}/b"])
    for theirs, answer in zip(stock, mine, strict=True):
        assert answer == theirs


def test_what_was_dumped_is_loaded_l200(master: Master, nodes: None, tmp_path: Path) -> None:
    """Stock's server in Python fails at any group, and so does stock's load; only ours leaves out what is as wanted."""
    ours, file = named_tool(tmp_path, "dynparam"), str(tmp_path / "file.yaml")
    for program, tools in ((DYNPARAM, stock_tools()), (ours, our_tools())):
        assert ask(tools, [program, "dump", "/theirs/a", file], master.environ()) == (0, "", False)
        assert ask(our_tools(), [ours, "load", "/theirs/a", file], master.environ()) == (0, "", False)


def test_lists_of_dynparam_l200(master: Master, nodes: None, tmp_path: Path) -> None:
    theirs = ask(stock_tools(), [DYNPARAM, "list"], master.environ())
    assert ask(our_tools(), [named_tool(tmp_path, "dynparam"), "list"], master.environ()) == theirs
    assert theirs[1].split() == ["/mine/a", "/mine/b", "/theirs/a", "/theirs/b"]


# The table ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("first", range(1, 213, 53))
def test_every_command_has_its_row(first: int) -> None:
    """And the tests that it names are there; without one stands only what cannot be, or is no command line."""
    table = (INTEROP / "commands.md").read_text(encoding="utf-8")
    for number in range(first, first + 53):
        row = re.search(rf"^\| L{number:02} \| [^|]+ \| ([^|]+) \| (.+) \|$", table, re.MULTILINE)
        assert row, f"commands.md has no row for L{number:02}"
        places = re.findall(r"`([^`]+)`", row[2])
        assert places or re.search("Qt|wx|cannot be", row[1]), row[0]
        for place in places:
            file, _, name = place.partition("::")
            path = INTEROP.parent / file
            assert path.is_file(), f"{row[0]}: there is no {file}"
            assert not name or f"def {name}(" in path.read_text(encoding="utf-8"), f"{row[0]}: no {name} in {file}"
