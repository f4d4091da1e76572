"""Where logs go (X86, N29, N30)."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from pyros1.ground.errors import LaunchError
from pyros1.launch.running.logs import log_folder, make_run_folder, ros_home


def test_folders(tmp_path: Path) -> None:
    assert ros_home({"ROS_HOME": "/h"}) == Path("/h")
    assert ros_home({}) == Path.home() / ".ros"
    assert log_folder({"ROS_HOME": "/h"}) == Path("/h/log")
    assert log_folder({"ROS_HOME": "/h", "ROS_LOG_DIR": "/l"}) == Path("/l")


def test_latest_points_to_the_last_run(tmp_path: Path) -> None:
    environ = {"ROS_LOG_DIR": str(tmp_path / "log")}
    for run_id in ("one", "two", "two"):
        folder = make_run_folder(environ, run_id)
        assert folder == tmp_path / "log" / run_id
        assert (tmp_path / "log" / "latest").resolve() == folder.resolve()


def test_a_folder_called_latest_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "latest").mkdir()
    assert make_run_folder({"ROS_LOG_DIR": str(tmp_path)}, "id").is_dir()
    assert not (tmp_path / "latest").is_symlink()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["id", "latest"]


def test_runs_need_no_link(tmp_path: Path) -> None:
    """Some file systems have none; here something else is where it is made."""
    (tmp_path / f"latest.{os.getpid()}").mkdir()
    assert make_run_folder({"ROS_LOG_DIR": str(tmp_path)}, "id").is_dir()
    assert not (tmp_path / "latest").exists()


@pytest.mark.parametrize("run_id", ["", ".", "..", "../other", "/etc", "a\0b"])
def test_a_run_has_a_folder_of_its_own(tmp_path: Path, run_id: str) -> None:
    """Any client of the master can set the id."""
    with pytest.raises(LaunchError, match="not a valid run id"):
        make_run_folder({"ROS_LOG_DIR": str(tmp_path / "log")}, run_id)
    assert not [*tmp_path.iterdir()]
