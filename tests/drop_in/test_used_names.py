"""The names of stock's modules that public programs use: counted in 44 public ROS 1 packages, 1,185 files, and found
by searching public code for names of the inner modules.

``used_names.txt`` has those that stock of ROS 1's last release has.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from programs import run

NAMES = Path(__file__).with_name("used_names.txt").read_text(encoding="utf-8").split()
LACKING = {
    "dynamic_reconfigure.cfg.TestConfig.Test_Medium",  # of that package's own tests
}
PROGRAM = """
import importlib, sys
for name in sys.argv[1:]:
    module, _, rest = name.partition(".")
    value = importlib.import_module(module)
    for part in rest.split("."):
        module += "." + part
        try:
            value = getattr(value, part)
        except AttributeError:
            try:
                value = importlib.import_module(module)
            except ImportError:
                print(name)
                break
"""


@pytest.mark.slow
def test_the_names_that_programs_use_are_there() -> None:
    assert len(NAMES) > 300
    assert set(run(PROGRAM, {}, *NAMES).split()) == LACKING
