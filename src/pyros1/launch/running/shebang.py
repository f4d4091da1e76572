"""Why the system cannot start a script: what its first line, which is to name an interpreter, says wrongly."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping
from pathlib import Path

_FIRST_LINE = 256
"""Bytes that Linux reads for it."""
_BOM = b"\xef\xbb\xbf"


def script_trouble(file: Path, environ: Mapping[str, str]) -> str:  # noqa: PLR0911 - one per trouble
    """Return why a script cannot be started and what to do; empty if nothing is seen, or it is no script.

    Args:
        file: an executable.
        environ: that it is started with; PATH is looked at.
    """
    try:
        with file.open("rb") as stream:
            head = stream.read(_FIRST_LINE)
    except OSError:
        return ""
    if b"\0" in head:
        return ""  # a program
    if not head:
        return "the file is empty"
    if head.startswith(_BOM):
        return "it begins with a byte order mark: save it as UTF-8 without one"
    if not head.startswith(b"#!"):
        return f"its first line does not say which program runs it: put {_proposal(file, head)} there"
    line = head.partition(b"\n")[0]
    if line.endswith(b"\r"):
        return f"its lines end as on Windows (CR LF), in the first one too: sed -i 's/\\r$//' {file}"
    return _interpreter_trouble(line[2:].decode(errors="replace").split(), environ)


def _proposal(file: Path, head: bytes) -> str:
    python = file.suffix == ".py" or any(word in head for word in (b"import ", b"def ", b'"""', b"coding"))
    return "#!/usr/bin/env python3" if python else "#!/bin/sh, #!/usr/bin/env python3 or the like"


def _interpreter_trouble(words: list[str], environ: Mapping[str, str]) -> str:
    if not words:
        return "its first line says #! without a program"
    program = words[0]
    if os.path.basename(program) == "env" and os.path.isfile(program):
        return _env_trouble(program, words[1:], environ)
    if not os.path.isabs(program):
        return f"its first line must name a program with its whole path, not '{program}': #!/usr/bin/env {program}"
    if os.path.isfile(program):
        return "" if os.access(program, os.X_OK) else f"its first line names {program}, which cannot be executed"
    return f"its first line names {program}, which is not on this machine{_instead(os.path.basename(program), environ)}"


def _env_trouble(env: str, words: list[str], environ: Mapping[str, str]) -> str:
    split = words[:1] in (["-S"], ["-vS"])
    if split:
        words = words[1:]
    elif len(words) > 1 and sys.platform == "linux":  # which passes them on as one
        return f"its first line hands {env} more than one word: write #!{env} -S {' '.join(words)}"
    while words and "=" in words[0]:
        words = words[1:]
    if not words or not words[0][0].isalnum():  # options, and what is quoted, may mean many things
        return ""
    return _missing_on_path(words[0], environ)


def _missing_on_path(name: str, environ: Mapping[str, str]) -> str:
    files = (os.path.join(folder, name) for folder in environ.get("PATH", os.defpath).split(os.pathsep))
    if any(os.path.isfile(file) and os.access(file, os.X_OK) for file in files):
        return ""
    return f"its first line asks for the program '{name}', which is not on the PATH{_instead(name, environ)}"


def _instead(name: str, environ: Mapping[str, str]) -> str:
    """A hint at the interpreter that there is."""
    if name.startswith("python") and name != "python3" and not _missing_on_path("python3", environ):
        return ": write #!/usr/bin/env python3, if it is a program for Python 3"
    return ": correct the line, or install the program"
