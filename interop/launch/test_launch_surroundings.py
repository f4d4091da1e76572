"""What nodes get from stock roslaunch and from ours: command line, environment, folder, group, log files (X83-X86).

Feature: launched nodes get the same environment as from roslaunch -- command line, environment variables, working
    directory, session, log files
"""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from harness import SOURCE, free_port, until

from pyros1.finding.python_modules import DROP_IN_START

pytestmark = pytest.mark.ours_only

PACKAGE = """<package format="2"><name>telling</name><version>1.0.0</version><description>Nodes.</description>
<maintainer email="a@example.org">a</maintainer><license>BSD</license></package>"""
# Prints what it has been given; the environment without what a shell sets itself, and without our modules.
TELL = """#!/usr/bin/python3
import os, sys
name = [word for word in sys.argv if word.startswith("__name:=")][0][8:]
environ = {key: value.replace(os.environ["MODULES"] + ":", "") for key, value in os.environ.items()}
lines = sys.argv + sorted(f"{key}={value}" for key, value in environ.items() if key != "PYROS1_PYTHON")
lines += [os.getcwd(), str(os.getpgid(0) == os.getpid() == os.getsid(0)), str(os.path.realpath("/dev/fd/1"))]
print("out", name)
print("err", name, file=sys.stderr, flush=True)
path = os.environ["TELL_TO"] + "/" + name
open(path + ".new", "w").write("\\n".join(lines))
os.rename(path + ".new", path)
"""
LAUNCH = """<launch>
  <env name="OUTER" value="a b"/>
  <node pkg="telling" type="tell" name="plain"/>
  <node pkg="telling" type="tell" name="screen" output="screen" cwd="node"/>
  <group ns="/deep/er">
    <remap from="x" to="/y"/><remap from="~p" to="q"/>
    <node pkg="telling" type="tell" name="words" args="1 'two words' &quot;&quot; -x:=y" ns="in">
      <env name="OUTER" value="inner"/><remap from="z" to="w"/><param name="p" value="1"/>
    </node>
  </group>
  <node pkg="telling" type="tell" name="prefixed" launch-prefix="env EXTRA='1 2' nice -n 1"/>
</launch>
"""


def told(who: str, folder: Path) -> dict[str, str]:
    """What the nodes told under one launcher, with what differs between any two runs taken out."""
    home, tell_to = folder / who / "home", folder / who / "told"
    tell_to.mkdir(parents=True)
    names = [tell_to / name for name in ("plain", "screen", "words", "prefixed")]
    command = ["roslaunch"] if who == "stock" else [sys.executable, "-m", "pyros1", "launch"]
    port = free_port()
    environ = {
        **os.environ,
        "ROS_HOME": str(home),
        "ROS_HOSTNAME": "localhost",
        "ROS_MASTER_URI": f"http://localhost:{port}",
        "ROS_PACKAGE_PATH": f"{folder / 'telling'}:/usr/share",
        "PYTHONPATH": str(SOURCE),
        "TELL_TO": str(tell_to),
        "MODULES": DROP_IN_START,
    }
    with subprocess.Popen(
        [*command, "tell.launch"], cwd=folder, env=environ, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as launcher:
        until(lambda: launcher.poll() is not None or all(map(Path.exists, names)), "all nodes have told")
        launcher.send_signal(signal.SIGINT)  # with a master of its own it does not end when its nodes have
        try:
            out, err = launcher.communicate(timeout=60)
        finally:
            launcher.kill()
    assert launcher.returncode == 0, err
    found = {path.name: path.read_text() for path in tell_to.iterdir()}
    (run,) = [path for path in (home / "log").iterdir() if path.name != "latest"]
    assert (home / "log" / "latest").resolve() == run.resolve()
    found.update({f"log {path.name}": path.read_text() for path in run.glob("*[a-z]-[1-9]-stdout.log")})
    found["screen"] += re.sub(r"[^\n]*\n", lambda line: line[0] if line[0].startswith("out ") else "", out)
    found["errors"] = "".join(sorted(line for line in err.splitlines(True) if line.startswith("err ")))
    for name, text in found.items():
        lines = re.sub(r"roslaunch-(.*)-\d+\.log", r"roslaunch-\1-PID.log", text)  # first: it may equal the port
        lines = lines.replace(str(folder / who), "WHO").replace(f":{port}", ":PORT").replace(run.name, "RUN")
        found[name] = re.sub(r"/proc/\d+/fd/pipe:\[\d+\]", "pipe\n", lines)
    found.pop("log rosout-1-stdout.log", None)  # stock's rosout is a process
    return found


def test_nodes_get_the_same_from_both(tmp_path: Path) -> None:
    package = tmp_path / "telling"
    package.mkdir()
    (package / "package.xml").write_text(PACKAGE)
    (package / "tell").write_text(TELL)
    (package / "tell").chmod(0o755)
    (tmp_path / "tell.launch").write_text(LAUNCH)
    ours, stock = told("ours", tmp_path), told("stock", tmp_path)
    assert set(ours) == set(stock)
    for name, text in stock.items():
        assert ours[name].splitlines() == text.splitlines(), name
