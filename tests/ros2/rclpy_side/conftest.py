"""A ROS 2 package as it is installed: Python modules, and definitions in a share folder."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

FILES = {
    "share/lab_msgs/msg/Bench.msg": "string data\n",
    "share/lab_msgs/msg/Chair.msg": "string data\n",
    "share/lab_msgs/srv/Clean.srv": "string data\n---\nstring data\n",
    "share/lab_msgs/action/Walk.action": "int32 a\n---\nint32 b\n---\nint32 c\n",
    "share/bad_msgs/msg/Bench.msg": "string data\n",
    "lib/site/lab_msgs/__init__.py": "",
    "lib/site/lab_msgs/msg.py": "class Bench:\n    def __init__(self, data=b''):\n        self.data = data\n",
    "lib/site/lab_msgs/srv.py": "from lab_msgs.msg import Bench\nclass Clean:\n    Request = Response = Bench\n",
    "lib/site/lab_msgs/action.py": (
        "class Walk:\n    class Impl:\n"
        "        SendGoalService, GetResultService, FeedbackMessage = 'send', 'result', 'feedback'\n"
    ),
    "lib/site/bad_msgs/__init__.py": "",
    "lib/site/bad_msgs/msg.py": "raise ImportError('of another Python')\n",
    "lib/site/no_msgs/__init__.py": "raise AssertionError('it was imported')\n",
}


@pytest.fixture
def prefix(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The folder in which the packages are installed."""
    for name, text in FILES.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    monkeypatch.delenv("AMENT_PREFIX_PATH", raising=False)
    monkeypatch.setattr(sys, "path", [str(tmp_path / "lib/site"), *sys.path])
    yield tmp_path
    for name in [name for name in sys.modules if name.partition(".")[0] in ("lab_msgs", "bad_msgs", "no_msgs")]:
        del sys.modules[name]
