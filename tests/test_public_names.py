"""What people find who look for names: dir(), which completion in IPython and elsewhere uses too."""

from __future__ import annotations

import subprocess
import sys

import pytest

CODE = """
import pyros1, pyros1.bag, pyros1.diagnostics, pyros1.filters, pyros1.reconfigure, pyros1.tf, pyros1.msgs
for module in (pyros1, pyros1.bag, pyros1.diagnostics, pyros1.filters, pyros1.reconfigure, pyros1.tf):
    assert {*module.__all__} <= {*dir(module)}, module
    assert not {"Any", "TYPE_CHECKING", "annotations"} & {*dir(module)}, module
    for name in module.__all__:
        getattr(module, name)
assert {"load_message", "std_msgs", "geometry_msgs"} <= {*dir(pyros1.msgs)}
from pyros1.msgs.geometry_msgs import msg
assert {"Twist", "Pose"} <= {*dir(msg)}
assert "linear" in msg.Twist.__doc__.split()
"""


@pytest.mark.slow
def test_all_public_names_are_in_dir() -> None:
    subprocess.run([sys.executable, "-c", CODE], check=True, timeout=60)
