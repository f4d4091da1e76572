"""The names of rospy's modules, and how they are called: ours beside stock's (P40, P42, P43).

Feature: rospy's names, parameters and behaviour -- the same programs run on stock's modules, on ours, and with one
    side on each
"""

from __future__ import annotations

import functools
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from faces import START
from harness import SOURCE, STOCK_PYTHON

HERE = Path(__file__).parent
MODULES = [
    "rospy",
    *(
        "rospy." + name
        for name in ["client", "core", "exceptions", "msg", "msproxy", "names", "numpy_msg", "rostime", "service"]
    ),
    *("rospy." + name for name in ["timer", "topics", "logger_level_service_caller"]),
    *("rospy.impl." + name for name in ["paramserver", "tcpros_base", "tcpros_service"]),
]
LEFT_OUT = {
    "rospy.impl.tcpros_base": """
        TCPROSServer TCPServer get_tcpros_server_address init_tcpros_server recv_buff
        """,
    "rospy.impl.tcpros_service": "TCPService service_connection_handler",
    "rospy.topics": "Poller",
}
"""Names that no public program uses: an error says what ours have in their place."""
ONE_LINE = """
import importlib, sys
for name in sys.argv[1:]:
    module, _, last = name.rpartition(".")
    try:
        getattr(importlib.import_module(module), last)
    except AttributeError as error:
        assert str(error).startswith(f"pyros1 has no {name}: "), error
    else:
        raise AssertionError(name)
"""


def ask(script: str, face: str, *arguments: str, given: str = "") -> dict[str, Any]:
    """Return what a script says of modules."""
    stock = face == "stock"
    environ = {**os.environ, "PYTHONPATH": "" if stock else f"{START}:{SOURCE}"}
    command = [STOCK_PYTHON if stock else sys.executable, str(HERE / script), *arguments]
    done = subprocess.run(command, env=environ, capture_output=True, text=True, timeout=60, check=True, input=given)
    answer: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return answer


@functools.cache
def names(face: str) -> dict[str, list[str]]:
    """Return the names of all modules: all on stock, and of these what there is on ours."""
    if face == "stock":
        return ask("surface.py", face, "list", *MODULES)
    return ask("surface.py", face, "have", given=json.dumps(names("stock")))


@functools.cache
def signatures(face: str) -> dict[str, dict[str, Any]]:
    """Return the parameters of all functions."""
    return ask("signatures.py", face, *MODULES)


@pytest.mark.parametrize("module", [name for name in MODULES if name != "rospy.impl.tcpros_base"])
def test_names(module: str) -> None:
    missing = {name.partition(".")[0] for name in set(names("stock")[module]) - set(names("ours")[module])}
    missing.discard("TCPROSServiceClient")  # has it, without read_messages
    assert missing == set(LEFT_OUT.get(module, "").split())


def test_names_that_are_left_out_say_so() -> None:
    left_out = [f"{module}.{name}" for module, names in LEFT_OUT.items() for name in names.split()]
    environ = {**os.environ, "PYTHONPATH": f"{START}:{SOURCE}"}
    subprocess.run([sys.executable, "-c", ONE_LINE, *left_out], env=environ, timeout=60, check=True)


@pytest.mark.parametrize("module", MODULES)
def test_parameters(module: str) -> None:
    ours, stock = (signatures(face)[module] for face in ("ours", "stock"))
    both = [name for name in stock if name in ours and not name.startswith(("AnyMsg.", "Message."))]
    assert both or module == "rospy.exceptions"
    wrong = {name: (ours[name], stock[name]) for name in both if not _takes(ours[name], stock[name])}
    assert not wrong


def _takes(ours: list[Any], stock: list[Any]) -> bool:
    """Tell whether ours can be called as stock's: more parameters are allowed if they have defaults."""
    if ours[: len(stock)] == stock:
        return all(optional or kind.startswith("VAR") for _, kind, optional in ours[len(stock) :])
    return any(kind == "VAR_POSITIONAL" for _, kind, _ in ours) and any(kind == "VAR_KEYWORD" for _, kind, _ in ours)
