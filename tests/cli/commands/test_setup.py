"""`pyros1 setup` in real shells: the stock names, functions and completion come, and go without a trace.

Feature: stock command names, functions and completion in bash, zsh, fish and sh; can be undone -- `source <(pyros1
    setup)`
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from pyros1.cli.commands.setup._programs import SetupError, make_programs
from pyros1.cli.registry import stock_names
from pyros1.cli.shared.shells import detect_shell

pytestmark = pytest.mark.once

SOURCE = Path(__file__).resolve().parents[3] / "src"

# Each script prints what the shell holds before and after into files, and what the stock names do to its output. The
# shell had functions and completions of the same names before.
BASH = r"""
rostopic() { echo mine; }
roscd() { echo "my roscd"; }
complete -W "a b" rosnode
snap() {
  declare -f; complete -p; shopt; set -o; alias
  declare -p | grep -vE '^declare -[^ ]+ (BASH.*|FUNCNAME|_|S?RANDOM|SECONDS|EPOCH.*|PIPESTATUS|LINENO|COMP.*|OLDPWD)='
}
offer() { COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _pyros1_complete; printf '[%s]' "${COMPREPLY[@]}"; echo; }
snap >before
source <(pyros1 setup)
source <(pyros1 setup)
type -t roscd rospd rosd
type -P rospack catkin_create_pkg rosed | sed 's,.*/,,'
rospack find minimal_nodes
roscd minimal_nodes/launch && pwd && roscd nope
cd "$OLDPWD"
offer rostopic ec
offer roslaunch minimal_nodes minimal_nodes.launch ra
offer rostopic pub /x std_msgs/String ''
pyros1 --version >/dev/null && echo version
source <(pyros1 unsetup)
snap >after
"""
ZSH = r"""
autoload -Uz compinit && compinit -D -u
function rostopic { echo mine }
function roscd { echo "my roscd" }
compdef _ls rosnode
snap() { functions; setopt; alias; print -l $path; typeset -p _comps; typeset | grep -iE 'pyros1|^path|^PATH' }
snap >/dev/null
snap >before
source <(pyros1 setup)
source <(pyros1 setup)
whence -w roscd rospd rosd | sed 's/.*: //'
whence -p rospack catkin_create_pkg rosed | sed 's,.*/,,'
rospack find minimal_nodes
roscd minimal_nodes/launch && pwd && roscd nope
cd "$OLDPWD"
function compadd { shift 3; print -r -- "[${@[-1]}]" }
offer() { local words=("$@") CURRENT=$#; _pyros1_complete }
offer rostopic ec
offer roslaunch minimal_nodes minimal_nodes.launch ra
offer rostopic pub /x std_msgs/String ''
pyros1 --version >/dev/null && echo version
unfunction compadd offer
source <(pyros1 unsetup)
snap >after
"""
FISH = r"""
function rostopic; echo mine; end
function roscd; echo "my roscd"; end
complete -c rosnode -a 'a b'
function snap
    for each in (functions -n | string split ', ' | grep ros)
        functions $each | grep -v '^# Defined'
    end
    complete | grep -i ros | sort
    set -n | grep -vE '^(status|pipestatus|dirprev|dirnext|__fish_cd_direction)$'
    printf '%s\n' $PATH
end
cd .
snap >before
pyros1 setup | source
pyros1 setup | source
for each in roscd rospd rosd; functions -q $each; and echo function; end
command -s rospack catkin_create_pkg rosed | sed 's,.*/,,'
set -l here $PWD
rospack find minimal_nodes
roscd minimal_nodes/launch; and pwd; and roscd nope
cd $here
function offer; printf '[%s]' (complete -C $argv[1]); echo; end
offer 'rostopic ec'
offer 'roslaunch minimal_nodes minimal_nodes.launch ra'
offer 'rostopic pub /x std_msgs/String '
pyros1 --version >/dev/null; and echo version
functions -e offer
pyros1 unsetup | source
snap >after
"""
SH = r"""
set -eu
each=
snap() { set | grep -vE "^(_|OLDPWD|PPID|OPTIND|LINENO)="; alias; command -v rostopic roscd _pyros1_undo || true; }
snap >before
eval "$(pyros1 setup)"
eval "$(pyros1 setup)"
case "$(command -v roscd)" in */*) ;; *) echo function ;; esac
for each in rospack catkin_create_pkg rosed; do command -v $each | sed 's,.*/,,'; done
rospack find minimal_nodes
roscd minimal_nodes/launch && pwd
roscd nope || true
cd "$OLDPWD"
pyros1 --version >/dev/null && echo version
each=
eval "$(pyros1 unsetup)"
snap >after
"""
SHELLS = {
    "bash": (["bash", "--norc", "--noprofile"], BASH, "[\"data: ''\"]"),
    "zsh": (["zsh", "-f"], ZSH, "[\"data: ''\"]"),
    "fish": (["fish", "--no-config"], FISH, "[{data: ''}]"),
}


@pytest.fixture
def place(tmp_path: Path) -> Path:
    """A folder with spaces in its name, with a ``pyros1`` as an installer makes it."""
    folder = tmp_path / "a place with 'spaces'"
    (folder / "bin").mkdir(parents=True)
    program = folder / "bin" / "pyros1"
    program.write_text(f'#!/bin/sh\nPYTHONPATH="{SOURCE}" exec "{sys.executable}" -m pyros1 "$@"\n')
    program.chmod(0o755)
    return folder


def environment(place: Path, master_port: int = 9) -> dict[str, str]:
    return {
        "PATH": f"{place / 'bin'}:/usr/bin:/bin",
        "HOME": str(place),
        "ROS_MASTER_URI": f"http://127.0.0.1:{master_port}",
        "LANG": "C.UTF-8",
        "TERM": "dumb",
    }


def run_shell(
    shell: str, command: list[str], place: Path, script: str, master_port: int = 9
) -> subprocess.CompletedProcess[str]:
    file = place / f"script.{shell}"
    file.write_text(script)
    return subprocess.run(
        [*command, str(file)], cwd=place, env=environment(place, master_port), stdin=subprocess.DEVNULL,
        capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("shell", SHELLS)
def test_what_comes_goes_without_a_trace(place: Path, shell: str) -> None:
    command, script, template = SHELLS[shell]
    if shutil.which(shell) is None:
        pytest.skip(f"there is no {shell} here")
    done = run_shell(shell, command, place, script)
    packages = SOURCE / "pyros1" / "packages"
    assert done.stdout.splitlines() == [
        *["function"] * 3,
        "rospack",
        "catkin_create_pkg",
        "rosed",
        str(packages / "minimal_nodes"),
        str(packages / "minimal_nodes" / "launch"),
        "[echo]",
        "[rate:=]",
        template,
        "version",
    ], done.stderr
    assert done.stderr.splitlines() == ["roscd: No such package/stack 'nope'"]
    before, after = (
        [line for line in (place / name).read_text().splitlines() if "OLDPWD" not in line]
        for name in ("before", "after")
    )
    assert before == after and len(before) > 10


@pytest.mark.slow
def test_plain_sh(place: Path) -> None:
    if shutil.which("dash") is None:
        pytest.skip("there is no dash here")
    done = run_shell("dash", ["dash"], place, SH)
    folder = SOURCE / "pyros1" / "packages" / "minimal_nodes"
    assert done.stdout.splitlines() == [
        *["function", "rospack", "catkin_create_pkg", "rosed"],
        *[str(folder), str(folder / "launch"), "version"],
    ], done.stderr
    assert done.stderr.splitlines() == ["roscd: No such package/stack 'nope'"]
    assert (place / "before").read_text() == (place / "after").read_text() != ""


SET_UP = {
    "dash": 'eval "$(pyros1 {})"',
    "fish": "pyros1 {} | source",
    **dict.fromkeys(("bash", "zsh"), "source <(pyros1 {})"),
}


@pytest.mark.parametrize("shell", SET_UP)
def test_a_shell_that_was_not_set_up_says_so(place: Path, shell: str) -> None:
    if shutil.which(shell) is None:
        pytest.skip(f"there is no {shell} here")
    done = run_shell(shell, SHELLS.get(shell, ([shell],))[0], place, SET_UP[shell].format("unsetup"))
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "pyros1: this shell was not set up\n")


@pytest.mark.slow
@pytest.mark.parametrize("shell", SET_UP)
@pytest.mark.parametrize(("program", "number"), [("pyros1 core", "TERM"), ("pyros1 core", "INT"), ("roscore", "TERM")])
def test_what_runs_in_the_background_is_the_program(
    place: Path, shell: str, program: str, number: str, free_port: int
) -> None:
    """``kill $!`` must end the program and not a copy of the shell that waits for it."""
    if shutil.which(shell) is None:
        pytest.skip(f"there is no {shell} here")
    pid, code, until = "$!", "$?", "until [ -s lines ]; do sleep 0.02; done"
    if shell == "fish":
        pid, code, until = "$last_pid", "$status", "while not test -s lines; sleep 0.02; end"
    script = f"""
{SET_UP[shell].format("setup")}
{program} -p {free_port} >lines &
{until}
kill -{number} {pid}
wait {pid}
echo ended {code}
"""
    done = run_shell(shell, SHELLS.get(shell, ([shell],))[0], place, script, free_port)
    assert (done.stdout, done.stderr) == ("ended 0\n", "")


def programs(tmp_path: Path) -> Path:
    return make_programs(stock_names(), {"XDG_DATA_HOME": str(tmp_path)})


def test_programs_have_the_stock_names_and_are_brought_up_to_date(tmp_path: Path) -> None:
    folder = programs(tmp_path)
    (folder / "rosold").touch()
    (folder / "rostopic").write_text("old")
    assert programs(tmp_path) == folder
    assert {path.name for path in folder.iterdir()} == {*stock_names(), "pyros1"}
    done = subprocess.run(
        [folder / "rosmsg", "md5", "std_msgs/String"], env={}, capture_output=True, text=True, timeout=60, check=False
    )
    assert (done.returncode, done.stdout) == (0, "992ce8a1687cec8c8bd883ec73ca41d1\n")
    usage = subprocess.run([folder / "rosmsg"], env={}, capture_output=True, text=True, timeout=60, check=False)
    assert usage.stdout.startswith("rosmsg is a")


def test_several_installations_live_side_by_side(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first = programs(tmp_path)
    monkeypatch.setattr(sys, "executable", "/another/venv/bin/python")
    second = programs(tmp_path)
    assert first != second and "/another/venv" in (second / "rostopic").read_text()


def test_folders_of_others_are_not_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "pyros1").mkdir()
    (tmp_path / "pyros1").chmod(0o777)
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    monkeypatch.setattr("tempfile.gettempdir", lambda: str(temporary))
    assert temporary in programs(tmp_path).parents
    shutil.rmtree(temporary)
    temporary.write_text("in the way")
    with pytest.raises(SetupError, match="cannot write"):
        programs(tmp_path)


def test_the_shell_is_known_by_its_process(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "getppid", lambda: 0)
    assert detect_shell({"SHELL": "/usr/bin/fish"}) == "fish"
    assert detect_shell({"SHELL": "/bin/tcsh"}) == detect_shell({}) == "bash"


def test_installing_shadows_nothing() -> None:
    text = (SOURCE.parent / "pyproject.toml").read_text()
    scripts = text.partition("[project.scripts]")[2].partition("[")[0].split("\n")
    assert [line for line in scripts if line.strip()] == ['pyros1 = "pyros1.cli.main:entry"']
