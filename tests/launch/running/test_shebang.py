"""Why a script cannot be started."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
from pathlib import Path

import pytest

from pyros1.launch.running.shebang import script_problem

TROUBLES = {
    b"import sys\n": "its first line does not name an interpreter: add #!/usr/bin/env python3",
    b"echo hello\n": "its first line does not name an interpreter: add #!/bin/sh, #!/usr/bin/env python3 or",
    b"": "the file is empty",
    b"\xef\xbb\xbf#!/bin/sh\n": "it starts with a byte order mark: save it as UTF-8 without one",
    b"#!/bin/sh\r\necho hello\r\n": "it has Windows line endings (CR LF), which make its first line invalid: "
    "sed -i 's/\\r$//' ",
    b"#!\n": "its first line has #! without a program",
    b"#!/no/such/program -x\n": "its first line names /no/such/program, which does not exist: correct the line",
    b"#!/no/such/python\n": "names /no/such/python, which does not exist: write #!/usr/bin/env python3 if",
    b"#!/etc/passwd\n": "its first line names /etc/passwd, which cannot be executed",
    b"#!sh\n": "must name a program with its full path, not 'sh': #!/usr/bin/env sh",
    b"#!/usr/bin/env nothing5\n": "its first line names the program 'nothing5', which is not on the PATH: correct",
    b"#!/usr/bin/env python2.5\n": "'python2.5', which is not on the PATH: write #!/usr/bin/env python3 if it is",
    b"#!/usr/bin/env -S A=b nothing5 -u\n": "names the program 'nothing5'",
}
FINE = [
    b"#!/bin/sh\n",
    b"#! /bin/sh -e\n",
    b"#!/bin/sh",
    b"#!/usr/bin/env sh\n",
    b"#!/usr/bin/env -S A=b sh -e\n",
    b"#!/usr/bin/env -S -u HOME sh\n",
    b"#!/usr/bin/env -i\n",
    b"\x7fELF\0\0\0",
]


@pytest.fixture
def environ(tmp_path: Path) -> dict[str, str]:
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin" / "python3").symlink_to(sys.executable)
    return {"PATH": f"{tmp_path / 'bin'}:{os.defpath}"}


@pytest.mark.parametrize("text", TROUBLES, ids=lambda text: repr(text[:30]))
def test_what_is_wrong_is_said_and_the_system_agrees(tmp_path: Path, environ: dict[str, str], text: bytes) -> None:
    file = tmp_path / "script"
    file.write_bytes(text)
    file.chmod(0o755)
    assert TROUBLES[text] in script_problem(file, environ)
    with contextlib.suppress(OSError):
        assert subprocess.run([file], env=environ, cwd="/", capture_output=True, check=False).returncode in (126, 127)


@pytest.mark.parametrize("text", FINE, ids=lambda text: repr(text[:30]))
def test_nothing_is_wrong(tmp_path: Path, environ: dict[str, str], text: bytes) -> None:
    file = tmp_path / "script"
    file.write_bytes(text)
    assert script_problem(file, environ) == ""


@pytest.mark.skipif(sys.platform != "linux", reason="other systems pass the words on one by one")
def test_env_gets_one_word(tmp_path: Path, environ: dict[str, str]) -> None:
    file = tmp_path / "script"
    file.write_bytes(b"#!/usr/bin/env python3 -u\n")
    assert script_problem(file, environ).endswith("write #!/usr/bin/env -S python3 -u")


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    assert script_problem(tmp_path / "none", {}) == ""
