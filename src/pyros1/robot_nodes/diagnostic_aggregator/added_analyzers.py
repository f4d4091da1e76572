"""Analyzers that other nodes add while aggregator_node is running, and that are removed when those nodes exit."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from functools import partial
from typing import Any

from pyros1.ground.errors import Error
from pyros1.ground.terminal_text import one_line
from pyros1.msgs.diagnostic_msgs.srv import AddDiagnostics
from pyros1.node import Node
from pyros1.robot_nodes.diagnostic_aggregator.aggregator import Aggregator
from pyros1.robot_nodes.diagnostic_aggregator.analyzers import AnalyzerGroup
from pyros1.robot_nodes.diagnostic_aggregator.configuration import AnalyzerFactory
from pyros1.robot_nodes.shared.bond_link import BondLink

SERVICE = "/diagnostics_agg/add_diagnostics"
BOND_TOPIC = "/diagnostics_agg/bond"
"""Prefix of a bond's topic; it is followed by the namespace, which is also the bond's name."""
MAX_NAMESPACES = 100


class AddedAnalyzers:
    """Provides the service /diagnostics_agg/add_diagnostics.

    A node requests a namespace, whose parameters define its analyzers, and keeps a bond with the aggregator. The
    analyzers are added to the tree when the bond is formed, and removed when it breaks.

    Args:
        node: the aggregator's node.
        lock: guards the aggregator.
        aggregator: the aggregator to which analyzers are added.
        factory: creates the analyzers.
        base_path: the parent path of the analyzers in the tree.
    """

    def __init__(
        self, node: Node, lock: threading.Lock, aggregator: Aggregator, factory: AnalyzerFactory, base_path: str
    ) -> None:
        self._node, self._factory, self._base_path = node, factory, base_path
        self._lock, self._aggregator = lock, aggregator
        self._bonds: dict[str, BondLink | None] = {}
        self._bonds_lock = threading.Lock()
        node.on_shutdown(self._close)
        node.advertise_service(SERVICE, AddDiagnostics, self._serve)

    def _serve(self, request: Any) -> tuple[bool, str]:
        namespace = request.load_namespace
        if not namespace.startswith("/"):
            return False, (
                "Requested load from non-global namespace. Private and relative namespaces are not supported."
            )
        with self._bonds_lock:
            if namespace in self._bonds:
                return False, f"Requested load from namespace {namespace} which is already in use"
            if len(self._bonds) >= MAX_NAMESPACES:
                return False, f"There are {MAX_NAMESPACES} namespaces already."
            self._bonds[namespace] = None  # so that a second request for it is rejected meanwhile
        try:
            problem = self._add(namespace)
        except Error as error:
            problem = one_line(str(error), 200)
        if problem:
            self._forget(namespace)
            return False, f"Failed to initialise AnalyzerGroup. {problem}"
        return True, "Successfully initialised AnalyzerGroup. Waiting for bond to form."

    def _add(self, namespace: str) -> str:
        """Create analyzers, and start to form the bond; return an error message, or an empty string."""
        values = self._node.params.get(f"{namespace}/analyzers", None)
        place = f"{namespace}/analyzers"
        if not isinstance(values, Mapping):
            return f"Load the analyzers to the parameter {place}."
        group = self._factory.make_group(self._base_path, "", values, place, self._node.now().to_sec())
        if group.problems or not group.analyzers:
            return f"Not all of {place} can be used: see the log of {self._node.name}."
        formed, broken = partial(self._on_formed, namespace, group), partial(self._on_broken, namespace, group)
        link = BondLink(self._node, f"{BOND_TOPIC}{namespace}", namespace, formed, broken)
        with self._bonds_lock:
            if namespace in self._bonds:
                self._bonds[namespace] = link
        return ""

    def _forget(self, namespace: str) -> None:
        with self._bonds_lock:
            self._bonds.pop(namespace, None)

    def _on_formed(self, namespace: str, group: AnalyzerGroup) -> None:
        with self._lock:
            self._aggregator.add(group)
        self._node.log.info("added the analyzers of %s", namespace)

    def _on_broken(self, namespace: str, group: AnalyzerGroup) -> None:
        with self._lock:
            self._aggregator.remove(group)
        self._forget(namespace)
        self._node.log.warn("the bond with %s is broken or was never formed: its analyzers are removed", namespace)

    def _close(self) -> None:
        with self._bonds_lock:
            links = [link for link in self._bonds.values() if link is not None]
        for link in links:  # end all bonds first: `close` waits for a node that does not respond
            link.end()
        for link in links:
            link.close()
