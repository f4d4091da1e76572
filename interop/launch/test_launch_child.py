"""A stock launcher whose remote machine has pyros1 alone: the ``roslaunch -c`` that it starts is ours (L151-L153).

Feature: a stock launcher's nodes on our machine -- `pyros1 launch -c`
"""

from __future__ import annotations

import contextlib
import getpass
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from harness import SOURCE, Process, free_port, until
from sshd import loopback_sshd

pytestmark = pytest.mark.ours_only

LAUNCH = """<launch>
  <machine name="far" address="localhost" user="{user}" ssh-port="{port}" env-loader="{folder}/env.sh" timeout="20"/>
  <group ns="g">
    <remap from="a" to="b"/>
    <node pkg="topic_tools" type="relay" name="far" args="/in /out" machine="far" respawn="true" respawn_delay="0.2">
      <env name="MARK" value="two words"/>
    </node>
    <node pkg="topic_tools" type="nothing" name="bad" machine="far"/>
    <node pkg="topic_tools" type="relay" name="near" args="/out /back"/>
  </group>
</launch>
"""


@dataclass
class Launched:
    """A stock launcher with a machine "far", and its surroundings."""

    parent: Process
    folder: Path
    environ: dict[str, str]

    def started(self, name: str) -> int:
        """The pid that the launcher says of a node."""
        pattern = rf"process\[g/{name}-\d+\]: started with pid \[(\d+)\]"
        return int(self.parent.wait_line(pattern, timeout=30)[1])


@pytest.fixture
def launched(tmp_path: Path) -> Iterator[Launched]:
    (tmp_path / "bin").mkdir()
    command = tmp_path / "bin" / "roslaunch"
    command.write_text(f'#!/bin/sh\nPYTHONPATH={SOURCE} exec {sys.executable} -m pyros1 launch "$@"\n')
    exports = {"ROS_HOME": f"{tmp_path}/far_home", "ROS_HOSTNAME": "localhost", "ROS_PACKAGE_PATH": "/usr/share"}
    lines = "".join(f"export {name}='{value}'\n" for name, value in exports.items())
    (tmp_path / "env.sh").write_text(f'#!/bin/sh\n{lines}export PATH={tmp_path}/bin:$PATH\nexec "$@"\n')
    for file in (command, tmp_path / "env.sh"):
        file.chmod(0o755)
    environ = {
        **os.environ,
        "HOME": str(tmp_path),
        "PYTHONUNBUFFERED": "1",  # stock does not flush what it prints into a pipe
        "LOGNAME": "somebody",  # stock takes a machine of this name and user for this one
        "ROS_HOME": str(tmp_path / "near_home"),
        "ROS_HOSTNAME": "localhost",
        "ROS_MASTER_URI": f"http://localhost:{free_port()}",
        "ROS_PACKAGE_PATH": "/usr/share",
    }
    with loopback_sshd(tmp_path) as port:
        file = tmp_path / "far.launch"
        file.write_text(LAUNCH.format(user=getpass.getuser(), port=port, folder=tmp_path))
        parent = Process(["roslaunch", str(file)], environ, "stock roslaunch")
        yield Launched(parent, tmp_path, environ)
        # A stock launcher that is killed leaves its own master, rosout and nodes behind.
        for words in Path("/proc").glob("[0-9]*/cmdline"):
            with contextlib.suppress(OSError):
                if f"{tmp_path}/near_home/" in words.read_text():
                    os.kill(int(words.parent.name), signal.SIGKILL)
        parent.close()


def gone(pid: int) -> bool:
    return not Path(f"/proc/{pid}").exists()


def test_stock_parent_is_served(launched: Launched) -> None:
    far = launched.started("far")
    launched.parent.wait_line(r"\[localhost-0\]: ERROR: cannot launch node of type \[topic_tools/nothing\]")
    until(Path(f"/proc/{far}/cmdline").read_text, "its program has begun")  # it is empty for a moment
    words = Path(f"/proc/{far}/cmdline").read_text().split("\0")[:-1]
    assert words[:-1] == ["/usr/lib/topic_tools/relay", "/in", "/out", "a:=b", "__name:=far"]
    log = re.fullmatch(rf"__log:=({launched.folder}/far_home/log/[^/]+/g-far-1)\.log", words[-1])
    assert log
    environ = dict(item.split("=", 1) for item in Path(f"/proc/{far}/environ").read_text().split("\0") if "=" in item)
    assert environ["MARK"] == "two words" and environ["ROS_NAMESPACE"] == "/g"
    assert environ["ROS_MASTER_URI"] == launched.environ["ROS_MASTER_URI"]
    for stream in ("stdout", "stderr"):
        assert Path(f"{log[1]}-{stream}.log").exists()
    status = subprocess.run(
        [sys.executable, "-m", "pyros1", "node", "status", "--once"],
        env={**launched.environ, "PYTHONPATH": str(SOURCE)},
        capture_output=True,
        text=True,
        timeout=30,
        check=True,
    )
    assert re.search(rf"^/g/far +running +{far}\b", status.stdout, re.M), status.stdout
    os.kill(far, signal.SIGKILL)
    launched.parent.wait_line(r"\[localhost-0\]: \[g/far-1\] process has died \[pid \d+, exit code -9, cmd ")
    launched.parent.wait_line(r"\[localhost-0\]: \[g/far-1\] restarting process")
    again = launched.started("far")
    launched.parent.signal(signal.SIGINT)
    launched.parent.wait_line(r"\[localhost-0\]: \[g/far-1\] killing on exit")
    assert launched.parent.wait(30) == 0
    until(lambda: gone(far) and gone(again), "nothing runs over there")


def test_a_killed_parent_leaves_nothing_over_there(launched: Launched) -> None:
    far = launched.started("far")
    os.kill(launched.parent.pid, signal.SIGKILL)
    until(lambda: gone(far), "the node over there has ended", timeout=30)
