"""add_analyzers: adds analyzers to a running aggregator_node (https://wiki.ros.org/diagnostic_aggregator).

``add_analyzers [YAML] [-t SECONDS]``: without a file, the analyzers are in the node's private parameters. They are
removed when this program ends.
"""

from __future__ import annotations

import argparse
import threading
from collections.abc import Mapping

from pyros1.ground.errors import Error, SettingError
from pyros1.msgs.diagnostic_msgs.srv import AddDiagnostics
from pyros1.node import Node
from pyros1.robot_nodes.diagnostic_aggregator.added_analyzers import BOND_TOPIC, SERVICE
from pyros1.robot_nodes.shared.bond_link import BondLink
from pyros1.robot_nodes.shared.user_files import read_regular_file
from pyros1.values import load_all_yaml

_CONNECT_TIMEOUT = 120.0
_POLL_PERIOD = 0.2
_MAX_FILE_SIZE = 1 << 20


def add_analyzers(node: Node, path: str | None, timeout: float | None) -> None:
    """Add analyzers, and return when the node shuts down.

    Args:
        node: the node, whose private parameters define the analyzers. Their namespace is the node's name.
        path: a YAML file to load into these parameters first; None for no file.
        timeout: how many seconds to wait for aggregator_node; None for no limit.

    Raises:
        Error: the file cannot be used, aggregator_node did not add the analyzers, or the bond with it broke.
    """
    if path is not None:
        _load(node, path)
    node.wait_for_service(SERVICE, timeout)
    is_broken = threading.Event()
    link = BondLink(node, f"{BOND_TOPIC}{node.name}", node.name, lambda: None, is_broken.set, _CONNECT_TIMEOUT)
    node.on_shutdown(link.close)
    response = node.service(SERVICE, AddDiagnostics)(node.name)
    if not response.success:
        raise SettingError(f"aggregator_node did not add the analyzers: {response.message}")
    node.log.info("the analyzers are in /diagnostics_agg")
    while node.ok() and not is_broken.wait(_POLL_PERIOD):
        pass
    if is_broken.is_set() and node.ok():
        raise SettingError("the bond with aggregator_node is broken, so the analyzers are gone: did it exit?")


def _load(node: Node, path: str) -> None:
    try:
        documents = load_all_yaml(read_regular_file(path, _MAX_FILE_SIZE).decode("utf-8"), path)
    except (OSError, ValueError) as error:
        raise SettingError(f"cannot read {path}: {error}") from None
    for document in documents:
        if not isinstance(document, Mapping):
            raise SettingError(f"{path} must contain parameters such as analyzers: {{imu: {{type: ...}}}}")
        for name, value in document.items():
            node.params[f"~{name}"] = value


def main(argv: list[str]) -> int:
    """Run add_analyzers; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    parser = argparse.ArgumentParser(
        prog="add_analyzers",
        description="Adds analyzers to the tree of aggregator_node, until this program ends.",
    )
    parser.add_argument("analyzer_yaml", nargs="?", help="a file with the analyzers; default: private parameters")
    parser.add_argument("-t", "--timeout", type=float, help="seconds to wait for aggregator_node; default: no limit")
    arguments = parser.parse_args([word for word in argv[1:] if ":=" not in word])
    with Node("add_analyzers", argv=argv[1:]) as node:
        try:
            add_analyzers(node, arguments.analyzer_yaml, arguments.timeout)
        except Error as error:
            if node.ok():
                node.log.fatal("%s", error)
                return 1
    return 0
