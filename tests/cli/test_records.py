"""The records of commands and verbs are whole, and suffice: a new verb is a new file and nothing else."""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import pyros1
from pyros1.cli import make_index, registry
from pyros1.cli.complete_values import PROVIDERS_BY_KIND
from pyros1.cli.main import entry
from pyros1.cli.records import COMMAND_GROUPS, Verb

SOURCE = Path(pyros1.__file__).parent
Pyros1 = Callable[[str], tuple[int, str, str]]


def records() -> list[tuple[str, Verb]]:
    """Return all verbs, and what commands without verbs do, each with what is typed for it."""
    found = []
    for name in registry.commands():
        found += [(f"{name} {verb}", registry.load_verb(name, verb)) for verb in registry.verbs(name)]
        alone = registry.load_command(name).verb
        found += [(name, alone)] if alone is not None else []
    return found


ALONE = {name for name in registry.commands() if registry.load_command(name).verb is not None}
"""Commands that run by a record of their own; those of them that have verbs help with all at once, as stock's tools."""
EXPLAINED_OTHERWISE = {"setup", "unsetup"}
"""Their help shows in its own way how they are used."""
RECORDS = [pytest.param(line, verb, id=line) for line, verb in records()]
SPOKEN = [
    record
    for record in RECORDS
    for line in (str(record.id),)
    if line not in EXPLAINED_OTHERWISE and (" " not in line or line.partition(" ")[0] not in ALONE)
]
"""Those with help of their own."""


def test_the_table_is_current() -> None:
    """If not: python -m pyros1.cli.make_index"""
    assert make_index.INDEX_FILE.read_text(encoding="utf-8") == make_index.index_source()


@pytest.mark.parametrize("path", make_index.DOCUMENTS, ids=lambda path: path.name)
def test_the_table_in_a_document_is_current(path: Path) -> None:
    """If not: python -m pyros1.cli.make_index"""
    assert path.read_text(encoding="utf-8") == make_index.render_document(path)


def test_names_are_unique() -> None:
    known = registry.commands()
    names = [
        word for name, each in known.items() for word in {name, each.stock, *each.aliases, *each.other_programs} if word
    ]
    names += [told.program for name in known for told in registry.verbs(name).values() if told.program]
    assert [name for name, count in Counter(names).items() if count > 1] == []
    for command in known:
        verbs = registry.verbs(command)
        words = [word for name, each in verbs.items() for word in (name, *each.aliases)]
        assert [word for word, count in Counter(words).items() if count > 1] == [], command


@pytest.mark.parametrize("name", registry.commands())
def test_a_command_says_what_it_is(name: str) -> None:
    command = registry.load_command(name)
    assert command.name == name and command.about and command.group in COMMAND_GROUPS
    assert command.verb or registry.verbs(name)
    for words in command.other_programs.values():
        assert not words or words[0].startswith("-") or not registry.verbs(name) or registry.find_verb(name, words[0])
    assert {*command.order} <= {*registry.verbs(name)}
    assert command.stock or not any(verb.in_stock_tool for verb in registry.verbs(name).values()), (
        "verbs of which tool?"
    )


@pytest.mark.parametrize(("line", "verb"), RECORDS)
def test_a_record_is_whole(line: str, verb: Verb) -> None:
    assert verb.about or line.partition(" ")[0] in ALONE
    assert all(option.help or option.hidden for option in verb.options)
    options = [name for option in verb.options for name in option.names]
    assert len(options) == len({*options}), "each option once"
    kinds = {kind for argument in verb.arguments for kind in argument.completion_kinds.split("|") if kind}
    assert kinds <= {*PROVIDERS_BY_KIND}
    assert not any(argument.repeatable for argument in verb.arguments[:-1])


# The shell function roscd goes to the folder that `pkg cd` prints, so that this may print no help.
@pytest.mark.parametrize(("line", "verb"), [each for each in SPOKEN if each.values[0] != "pkg cd"])
def test_help_shows_options_and_examples(line: str, verb: Verb, call_main: Any) -> None:
    code, out, err = call_main(entry, "pyros1", *line.split(), "-h")
    assert (code, err) == (0, "") and verb.examples
    assert [option.names for option in verb.options if not option.hidden and option.names[-1] not in out] == []
    for example, about in verb.examples:
        assert example.partition("\n")[0] in out and about in out


@pytest.mark.parametrize(("line", "verb"), [each for each in SPOKEN if each.values[1].parse is None])  # type: ignore[union-attr]
def test_wrong_options_end_with_usage_and_2(line: str, verb: Verb, call_main: Any) -> None:
    code, out, err = call_main(entry, "pyros1", *line.split(), "--no-such-option")
    assert (code, out) == (2, "")
    assert err.startswith(f"Usage: pyros1 {line}") and err.endswith("error: no such option: --no-such-option\n")


# A new verb -----------------------------------------------------------------------------------------------------------

SHOUT = """
from pyros1.cli.failures import UsageError
from pyros1.cli.records import Argument, Flag, Option, Verb


def run(invocation, options, args):
    if not args:
        raise UsageError("there is nothing to shout")
    print(" ".join(args).upper() + "!" * options.strength + "?" * options.unsure, invocation.resolve("x"))


VERB = Verb(
    "shout",
    "say it loudly",
    Option("-s", "--strength", type="int", default=1, metavar="N", help="how loudly"),
    Flag("--unsure", help="ask", pyros1_only=True),
    Argument("word", "throttle_unit", repeatable=True),
    examples=[("-s 3 help", "very loudly")],
    aliases=["yell"],
    run=run,
)
"""
MEGAPHONE = SHOUT.replace("VERB = Verb", "from pyros1.cli.records import Command\n\nSHOUT = Verb").replace(
    '"shout"', '""'
)
MEGAPHONE += 'COMMAND = Command("megaphone", "shout", SHOUT, group="inspect", stock="rosmegaphone")\n'


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a pyros1 that has the verb ``topic shout`` and the command ``megaphone``, each a new file."""
    target = tmp_path_factory.mktemp("copy") / "pyros1"
    for path in SOURCE.rglob("*.py"):
        relative = path.relative_to(SOURCE)
        if relative.parts[0] == "cli":
            (target / relative).parent.mkdir(parents=True, exist_ok=True)
            (target / relative).write_bytes(path.read_bytes())
    for path in SOURCE.iterdir():
        if path.name != "cli":
            (target / path.name).symlink_to(path)
    (target / "cli/commands/topic/shout.py").write_text(SHOUT)
    (target / "cli/commands/megaphone.py").write_text(MEGAPHONE)
    return target.parent


@pytest.fixture
def new(package: Path, tmp_path: Path) -> Pyros1:
    """Runs that pyros1, as a process; the first word may be the name of a stock tool."""

    def run(line: str) -> tuple[int, str, str]:
        called, *words = shlex.split(line)
        program = tmp_path / called
        program.write_text("import sys\nfrom pyros1.cli.main import entry\nsys.exit(entry())\n")
        env = {**os.environ, "PYTHONPATH": str(package), "ROS_MASTER_URI": "http://127.0.0.1:9/"}
        command = [sys.executable, str(program), *words]
        done = subprocess.run(command, env=env, capture_output=True, text=True, timeout=60, check=False)
        return done.returncode, done.stdout, done.stderr

    return run


@pytest.mark.slow
def test_a_new_verb_runs(new: Pyros1) -> None:
    assert new("pyros1 topic shout hello world") == (0, "HELLO WORLD! /x\n", "")
    assert new("pyros1 topic yell -s 3 a --unsure __ns:=/robot") == (0, "A!!!? /robot/x\n", "")
    assert new("rostopic shout a") == new("pyros1 topic shout a")


@pytest.mark.slow
def test_a_new_verb_is_listed(new: Pyros1) -> None:
    code, out, _ = new("pyros1 topic -h")
    assert code == 0 and "\n\tpyros1 topic pub\tpublish data to topic\n\tpyros1 topic shout\tsay it loudly\n" in out
    assert "\n\trostopic shout\tsay it loudly\n" in new("rostopic")[1]
    assert " pub type shout\n" in new("pyros1 help")[1], "at the end until the table is made anew"
    assert new("pyros1 topic shuot")[2].endswith("unknown command 'shuot' (did you mean 'shout'?)\n")
    assert "did you mean 'pyros1 topic shout'?" in new("pyros1 shout")[2]


def test_a_new_verb_has_help(new: Pyros1) -> None:
    code, out, _ = new("pyros1 topic shout -h")
    assert code == 0 and out.startswith("Usage: pyros1 topic shout [options] word...\n")
    assert "  -s N, --strength=N  how loudly\n  --unsure            ask\n" in out
    assert out.endswith("\nExamples:\n  pyros1 topic shout -s 3 help  very loudly\n")
    code, out, _ = new("rostopic shout -h")
    assert code == 0 and "--strength" in out and "--unsure" not in out and "Examples" not in out, "as stock's would"


@pytest.mark.slow
def test_a_new_verb_is_completed(new: Pyros1) -> None:
    def offered(line: str) -> list[str]:
        code, out, err = new(f"pyros1 __complete bash '' {len(line.split(' ')) - 1} {line or repr('')}")
        assert (code, err) == (0, "")
        return out.split("\0")[:-1]

    assert offered("pyros1 topic sh") == ["shout"]
    assert offered("rostopic shou") == ["shout"]
    assert offered("pyros1 topic shout --") == ["--help", "--strength", "--unsure"]
    assert offered("pyros1 topic shout a m") == offered("pyros1 topic yell a b m") == ["messages"]
    assert offered("pyros1 mega") == ["megaphone"]
    assert offered("rosmegaphone --str") == ["--strength"]


def test_a_new_verb_may_have_a_program_of_stock(package: Path, new: Pyros1) -> None:
    """By that program's name the verb is known, and it stays out of the list that the command's stock tool prints."""
    record = package / "pyros1/cli/commands/topic/shout.py"
    record.write_text(SHOUT.replace("run=run,", 'stock="rosshout",\n    run=run,'))
    try:
        assert "shout" not in new("rostopic")[1] and "pyros1 topic shout\t" in new("pyros1 topic")[1]
        assert new("pyros1 __complete bash '' 1 rosshout --")[1].split("\0")[:-1] == [
            "--help", "--strength", "--unsure",
        ]  # fmt: skip
    finally:
        record.write_text(SHOUT)


def test_wrong_usage_of_a_new_verb(new: Pyros1) -> None:
    usage = "Usage: pyros1 topic shout [options] word...\n\npyros1 topic: error: "
    assert new("pyros1 topic shout") == (2, "", usage + "there is nothing to shout\n")
    assert new("pyros1 topic shout --loud a") == (2, "", usage + "no such option: --loud\n")
    assert new("pyros1 topic shout -s x a") == (2, "", usage + "option -s: invalid integer value: 'x'\n")
    assert new("rostopic shout") == (2, "", usage.replace("pyros1 topic", "rostopic") + "there is nothing to shout\n")


@pytest.mark.slow
def test_a_new_command_without_verbs(new: Pyros1) -> None:
    assert new("pyros1 megaphone hello") == new("rosmegaphone hello") == (0, "HELLO! /x\n", "")
    assert "\n  megaphone   shout\n" in new("pyros1 help")[1]
    assert new("pyros1 megaphone -h")[1].startswith("Usage: pyros1 megaphone [options] word...\n")
    assert new("pyros1 megaphone")[0] == 2
