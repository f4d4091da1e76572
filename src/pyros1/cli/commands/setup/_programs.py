"""Writes the folder of small programs, one per stock name, that ``setup`` puts on the shell's PATH."""

from __future__ import annotations

import os
import shlex
import stat
import sys
import tempfile
from binascii import crc32
from collections.abc import Mapping
from pathlib import Path

from pyros1.ground.errors import Error


class SetupError(Error):
    """The shell cannot be set up."""


def make_programs(args_by_program: Mapping[str, tuple[str, ...]], environ: Mapping[str, str]) -> Path:
    """Create or update the folder of programs.

    Args:
        args_by_program: the arguments of ``pyros1`` for each program.
        environ: the environment variables, which determine the folder.

    Returns:
        The folder.

    Raises:
        SetupError: no candidate folder is writable, or the system has no Unix shells.
    """
    if not hasattr(os, "getuid"):
        raise SetupError(
            "this works only in Unix shells: type pyros1 before each command instead, as in pyros1 topic list"
        )
    import_root = str(Path(__file__).resolve().parents[4])
    installation_id = crc32(f"{sys.executable}\n{import_root}".encode())
    data_folder = environ.get("XDG_DATA_HOME") or os.path.join(os.path.expanduser("~"), ".local", "share")
    problems = []
    for base_folder in (Path(data_folder, "pyros1"), Path(tempfile.gettempdir(), f"pyros1-{os.getuid()}")):
        folder = base_folder / f"bin-{installation_id:08x}"
        try:
            base_folder.mkdir(parents=True, exist_ok=True, mode=0o700)
            _check_not_writable_by_others(base_folder)
            folder.mkdir(exist_ok=True, mode=0o700)
            _write_programs(folder, {"pyros1": (), **args_by_program}, import_root)
        except OSError as error:
            problems.append(f"{folder}: {error.strerror or error}")
            continue
        if os.pathsep in str(folder):
            raise SetupError(
                f"{folder} contains a colon and cannot be on the PATH; set XDG_DATA_HOME to another folder"
            )
        return folder
    raise SetupError("cannot write the programs: " + "; ".join(problems))


def _check_not_writable_by_others(folder: Path) -> None:
    """Raise OSError if other users could write programs to the folder."""
    folder_status = folder.stat()
    if folder_status.st_uid != os.getuid() or folder_status.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        raise OSError(f"other users can write to {folder}")


def _write_programs(folder: Path, args_by_program: Mapping[str, tuple[str, ...]], import_root: str) -> None:
    for obsolete_name in {path.name for path in folder.iterdir()} - args_by_program.keys():
        if not obsolete_name.startswith("."):  # other processes are writing files whose names begin with a dot
            (folder / obsolete_name).unlink(missing_ok=True)
    for name, args in args_by_program.items():
        file = folder / name
        program_text = _make_program_text(args, import_root)
        if not file.is_file() or file.read_text(encoding="utf-8") != program_text:
            temporary_file = folder / f".{name}.{os.getpid()}"
            temporary_file.write_text(program_text, encoding="utf-8")
            temporary_file.chmod(0o755)
            os.replace(temporary_file, file)


def _make_program_text(args: tuple[str, ...], import_root: str) -> str:
    """Return a Python program that sh starts: the interpreter's path may be too long for ``#!``, or contain spaces."""
    argv = f'["pyros1", *{list(args)!r}, *sys.argv[1:]]'
    return (
        f"#!/bin/sh\n'''exec' {shlex.quote(sys.executable)} \"$0\" \"$@\"\n' '''\n"
        "import _signal\n\nif callable(_signal.getsignal(_signal.SIGINT)):  # no traceback of imports\n"
        "    _signal.signal(_signal.SIGINT, _signal.SIG_DFL)\n"
        f"import sys\n\ndel sys.path[0]\nif {import_root!r} not in sys.path:\n    sys.path.append({import_root!r})\n"
        f"from pyros1.cli.main import entry\n\nsys.exit(entry({argv}, alone=True))\n"
    )
