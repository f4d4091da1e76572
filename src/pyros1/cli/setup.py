"""``pyros1 setup`` and ``pyros1 unsetup``: the stock names for this shell, and nothing for anybody else.

``source <(pyros1 setup)`` puts a folder of small programs on the shell's PATH, one per stock name, and adds functions
and completion. The folder belongs to this installation of pyros1; several live side by side.
"""

from __future__ import annotations

import argparse
import os
import shlex
import stat
import sys
import tempfile
from binascii import crc32
from collections.abc import Mapping
from pathlib import Path

from pyros1.cli import registry, setup_names
from pyros1.cli.setup_shells import PLAIN, SHELLS, Names
from pyros1.errors import Error

_DESCRIPTION = {
    "setup": "Prints what gives a shell the stock names (rostopic, roscd, ...) and completion, for it to read.",
    "unsetup": "Takes back what `pyros1 setup` did to this shell.",
}


class SetupError(Error):
    """The shell cannot be set up."""


def main(argv: list[str], word: str = "setup") -> int:
    """Run ``pyros1 setup``.

    Args:
        argv: the words behind.
        word: ``setup`` or ``unsetup``.

    Returns:
        The exit code.
    """
    examples = "\n".join(f"  {name:5} {shell.how.format(f'pyros1 {word}')}" for name, shell in SHELLS.items())
    parser = argparse.ArgumentParser(
        prog=f"pyros1 {word}",
        description=_DESCRIPTION[word],
        epilog=f"how to use it:\n{examples}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--shell", choices=sorted(SHELLS), help="default: the shell that calls")
    values, others = parser.parse_known_args(argv)
    if others:
        hint = f" (write --shell {others[0]})" if others[0] in SHELLS else ""
        parser.error(f"unrecognized arguments: {' '.join(others)}{hint}")
    name = values.shell or detect_shell(os.environ)
    shell = SHELLS[name]
    if sys.stdout.isatty():
        print(f"This text is for the shell to read. For {name} type:\n\n  {shell.how.format(f'pyros1 {word}')}\n")
        return 0
    if word == "unsetup":
        print(shell.undo())
        return 0
    names = {**setup_names.stock_names(), **registry.stock_names()}
    folder = make_programs(names, os.environ)
    print(shell.setup(str(folder), Names([*names, "pyros1"])), end="")
    return 0


def detect_shell(environ: Mapping[str, str]) -> str:
    """Return the shell that called: of the processes above this one the first that is a shell we know.

    A shell that only runs a script named pyros1 with our own arguments did not ask.
    """
    pid = os.getppid()
    for _ in range(4):
        try:
            status = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8", errors="replace")
        except OSError:
            break
        name = status[status.find("(") + 1 : status.rfind(")")].lstrip("-")
        if (name in SHELLS or name in PLAIN) and not _is_wrapper(pid):
            return name if name in SHELLS else "sh"
        pid = int(status[status.rfind(")") + 2 :].split()[1])
    name = os.path.basename(environ.get("SHELL", ""))
    return name if name in SHELLS else "bash"


def _is_wrapper(pid: int) -> bool:
    own = [os.fsencode(word) for word in sys.argv[1:]]
    try:
        words = Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")[:-1]
    except OSError:
        return False
    script = len(words) - len(own) - 1
    return script > 0 and os.path.basename(words[script]) == b"pyros1" and words[script + 1 :] == own


def make_programs(names: Mapping[str, tuple[str, ...]], environ: Mapping[str, str]) -> Path:
    """Make the folder of programs, or bring it up to date.

    Args:
        names: program -> words behind ``pyros1``.
        environ: environment variables, for where the folder is.

    Returns:
        The folder.

    Raises:
        SetupError: it cannot be written anywhere.
    """
    package = str(Path(__file__).resolve().parents[2])
    number = crc32(f"{sys.executable}\n{package}".encode())
    home = environ.get("XDG_DATA_HOME") or os.path.join(os.path.expanduser("~"), ".local", "share")
    problems = []
    for base in (Path(home, "pyros1"), Path(tempfile.gettempdir(), f"pyros1-{os.getuid()}")):
        folder = base / f"bin-{number:08x}"
        try:
            base.mkdir(parents=True, exist_ok=True, mode=0o700)
            _must_be_ours(base)
            folder.mkdir(exist_ok=True, mode=0o700)
            _write_programs(folder, {"pyros1": (), **names}, package)
        except OSError as error:
            problems.append(f"{folder}: {error.strerror or error}")
            continue
        if os.pathsep in str(folder):
            raise SetupError(f"{folder} has a colon in it and cannot stand on the PATH; set XDG_DATA_HOME")
        return folder
    raise SetupError("cannot write the programs: " + "; ".join(problems))


def _must_be_ours(folder: Path) -> None:
    """Raise OSError if somebody else could put programs there."""
    status = folder.stat()
    if status.st_uid != os.getuid() or status.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        raise OSError(f"others may write in {folder}")


def _write_programs(folder: Path, names: Mapping[str, tuple[str, ...]], package: str) -> None:
    for old in {path.name for path in folder.iterdir()} - names.keys():
        (folder / old).unlink()
    for name, words in names.items():
        file = folder / name
        text = _program(words, package)
        if not file.is_file() or file.read_text(encoding="utf-8") != text:
            temporary = folder / f".{name}.{os.getpid()}"
            temporary.write_text(text, encoding="utf-8")
            temporary.chmod(0o755)
            os.replace(temporary, file)


def _program(words: tuple[str, ...], package: str) -> str:
    """A program that is Python behind a first line for sh: the interpreter's path may be long and have spaces in it."""
    call = f'["pyros1", *{list(words)!r}, *sys.argv[1:]]'
    return (
        f"#!/bin/sh\n'''exec' {shlex.quote(sys.executable)} \"$0\" \"$@\"\n' '''\n"
        "import _signal\n\nif callable(_signal.getsignal(_signal.SIGINT)):  # no traceback of imports\n"
        "    _signal.signal(_signal.SIGINT, _signal.SIG_DFL)\n"
        f"import sys\n\ndel sys.path[0]\nif {package!r} not in sys.path:\n    sys.path.append({package!r})\n"
        f"from pyros1.cli.main import entry\n\nsys.exit(entry({call}, alone=True))\n"
    )
