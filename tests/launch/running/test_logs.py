"""Where logs go (X86, N29, N30)."""

from __future__ import annotations

from pathlib import Path

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
