"""Questions about launch files, to stock's roslaunch and to ours."""

from __future__ import annotations

import os
from pathlib import Path
from typing import NamedTuple

from harness import INTEROP, PEERS, our_tools, stock_roslaunch

CORPUS = INTEROP / "launch_corpus"


class Answer(NamedTuple):
    """What a tool said."""

    code: int
    out: str
    err: str


def stock(*words: str, cwd: Path = CORPUS, **variables: str) -> Answer:
    """Ask stock roslaunch."""
    path = f"{PEERS / 'quick'}:{os.environ['PATH']}"
    env = {**os.environ, "ROS_HOSTNAME": "localhost", "PATH": path, **variables}
    return Answer(*stock_roslaunch().ask(["roslaunch", *words], env, cwd=cwd))


def ours(*words: str, cwd: Path = CORPUS, **variables: str) -> Answer:
    """Ask ``pyros1 launch``."""
    env = {**os.environ, "ROS_HOSTNAME": "localhost", **variables}
    return Answer(*our_tools().ask(["roslaunch", *words], env, cwd=cwd))
