"""The master's API, with the program's name as caller."""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import Any

from pyros1.drop_in.process import PROCESS
from pyros1.net.hosts import master_uri
from pyros1.net.master_client import MasterClient
from pyros1.node.parameters.parameters import Parameters
from rospy.names import get_caller_id, get_resolved_mappings, resolve_name


class MasterProxy:
    """Calls of the master: ``proxy.getSystemState()``; and its parameters as a mapping.

    Attributes:
        target: the master's address. client: pyros1's client of it. parameters: the parameters.
    """

    def __init__(self, uri: str | None = None) -> None:
        node = PROCESS.node
        if node is not None and uri is None:
            self.client: Any = node.master
            self.parameters: Any = node.params
        else:
            self.client = MasterClient(get_caller_id(), uri or master_uri(os.environ, {}))
            self.parameters = Parameters(
                self.client, resolve_name, lambda: "", get_resolved_mappings(), lambda *_: None
            )
        self.target = self.client.uri

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)

        def call(*args: Any) -> Any:
            return self.client._raw(name, get_caller_id(), *args)

        return call

    def __getitem__(self, key: str) -> Any:
        return self.parameters[key]

    def __setitem__(self, key: str, value: Any) -> None:
        self.parameters[key] = value

    def __delitem__(self, key: str) -> None:
        del self.parameters[key]

    def __contains__(self, key: str) -> bool:
        return key in self.parameters

    def __iter__(self) -> Iterator[str]:
        return iter(self.parameters.names())
