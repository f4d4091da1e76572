"""pyros1 core's command line (L06-L13); what it does is tested with the launcher in launch/test_launch.py."""

from __future__ import annotations

import pytest

from pyros1.cli.running import run_command


def test_no_arguments_l13(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as caught:
        run_command("core", ["something"])
    assert caught.value.code == 2
    assert "pyros1 core does not take arguments" in capsys.readouterr().err


def test_help(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as caught:
        run_command("core", ["--help"])
    assert caught.value.code == 0
    out = capsys.readouterr().out
    assert all(
        flag in out
        for flag in ("--port", "-v", "--numworkers", "--timeout", "--master-logger-level", "--sigint-timeout")
    )
