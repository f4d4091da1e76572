"""Finds errors in the first line of a script that prevent the system from starting it."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping
from pathlib import Path

_FIRST_LINE_SIZE = 256
"""Number of bytes of the first line that Linux reads."""
_BOM = b"\xef\xbb\xbf"


def script_problem(file: Path, environ: Mapping[str, str]) -> str:  # noqa: PLR0911 - one per problem
    """Return the reason why a script cannot be started, and the fix; empty if it can, or if the file is not a script.

    Args:
        file: an executable file.
        environ: the script's environment; only PATH is used.
    """
    try:
        with file.open("rb") as stream:
            head = stream.read(_FIRST_LINE_SIZE)
    except OSError:
        return ""
    if b"\0" in head:
        return ""  # a binary program
    if not head:
        return "the file is empty"
    if head.startswith(_BOM):
        return "it starts with a byte order mark: save it as UTF-8 without one"
    if not head.startswith(b"#!"):
        return f"its first line does not name an interpreter: add {_suggest_first_line(file, head)}"
    line = head.partition(b"\n")[0]
    if line.endswith(b"\r"):
        return f"it has Windows line endings (CR LF), which make its first line invalid: sed -i 's/\\r$//' {file}"
    return _interpreter_problem(line[2:].decode(errors="replace").split(), environ)


def _suggest_first_line(file: Path, head: bytes) -> str:
    is_python = file.suffix == ".py" or any(word in head for word in (b"import ", b"def ", b'"""', b"coding"))
    return "#!/usr/bin/env python3" if is_python else "#!/bin/sh, #!/usr/bin/env python3 or similar"


def _interpreter_problem(words: list[str], environ: Mapping[str, str]) -> str:
    if not words:
        return "its first line has #! without a program"
    program = words[0]
    if os.path.basename(program) == "env" and os.path.isfile(program):
        return _env_problem(program, words[1:], environ)
    if not os.path.isabs(program):
        return f"its first line must name a program with its full path, not '{program}': #!/usr/bin/env {program}"
    if os.path.isfile(program):
        return "" if os.access(program, os.X_OK) else f"its first line names {program}, which cannot be executed"
    return f"its first line names {program}, which does not exist{_correction_hint(os.path.basename(program), environ)}"


def _env_problem(env: str, words: list[str], environ: Mapping[str, str]) -> str:
    has_split_option = words[:1] in (["-S"], ["-vS"])
    if has_split_option:
        words = words[1:]
    elif len(words) > 1 and sys.platform == "linux":  # Linux passes all words as one argument
        return f"its first line passes more than one argument to {env}: write #!{env} -S {' '.join(words)}"
    while words and "=" in words[0]:
        words = words[1:]
    if not words or not words[0][0].isalnum():  # options and quoted words may have many meanings
        return ""
    return _missing_on_path(words[0], environ)


def _missing_on_path(name: str, environ: Mapping[str, str]) -> str:
    files = (os.path.join(folder, name) for folder in environ.get("PATH", os.defpath).split(os.pathsep))
    if any(os.path.isfile(file) and os.access(file, os.X_OK) for file in files):
        return ""
    return f"its first line names the program '{name}', which is not on the PATH{_correction_hint(name, environ)}"


def _correction_hint(name: str, environ: Mapping[str, str]) -> str:
    """Return a hint on how to correct the name of an interpreter that does not exist."""
    if name.startswith("python") and name != "python3" and not _missing_on_path("python3", environ):
        return ": write #!/usr/bin/env python3 if it is a program for Python 3"
    return ": correct the line, or install the program"
