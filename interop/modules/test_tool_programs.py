"""Libraries of the tools and of robots: programs that use their names, with stock's modules and with ours.

Each program of ``programs/`` prints what the functions return and raise, for usual, odd and wrong arguments.
"""

from __future__ import annotations

from pathlib import Path

import faces
import pytest
from harness import Master

MASTERS = ("ours",)
OWN_MASTER = True  # of others, dead nodes may be left
pytestmark = pytest.mark.ours_only
PROGRAMS = Path(__file__).parent / "programs"


@pytest.mark.parametrize(
    "name",
    [
        "bag_rules",
        "bag_verbs",
        "binary_parameters",
        "dead_nodes",
        "images_shown",
        "kdl",
        "launch_config",
        "launch_core",
        "markers",
        "small_libraries",
        "tf2_registries",
        "tool_parts",
    ],
)
def test_the_same_as_stock(master: Master, name: str) -> None:
    # They print the transport of links, which is stock's here.
    assert faces.same(master, (PROGRAMS / f"{name}.py").read_text(), PYROS1_TRANSPORTS="tcp")
