"""Parameters that other nodes and tools can change while a node is running (https://wiki.ros.org/dynamic_reconfigure).

::

    import pyros1
    from pyros1.reconfigure import Parameters, Server

    parameters = Parameters()
    parameters.add("rate", 10.0, "of the output, in Hz", minimum=0.1, maximum=100.0)
    parameters.add("mode", 0, "of the motor", choices={"Slow": 0, "Fast": 1})

    def changed(config, level):
        print(config.rate, config.mode)
        return config

    with pyros1.Node("motor") as node:
        Server(node, parameters, changed)
        node.spin()

From elsewhere: ``pyros1 dynparam set motor mode Fast``, or ``Client(node, "motor").update({"mode": "Fast"})``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pyros1.reconfigure.client import Client
    from pyros1.reconfigure.config import Config
    from pyros1.reconfigure.description import Group, Parameters
    from pyros1.reconfigure.server import CallbackError, Server
    from pyros1.reconfigure.values import ParameterError

__all__ = ["CallbackError", "Client", "Config", "Group", "ParameterError", "Parameters", "Server"]

_EXPORTS = {
    "CallbackError": "pyros1.reconfigure.server",
    "Client": "pyros1.reconfigure.client",
    "Config": "pyros1.reconfigure.config",
    "Group": "pyros1.reconfigure.description",
    "ParameterError": "pyros1.reconfigure.values",
    "Parameters": "pyros1.reconfigure.description",
    "Server": "pyros1.reconfigure.server",
}


def __getattr__(name: str) -> Any:
    """Load and return a public name when it is first used."""
    from pyros1.ground.lazy import load  # noqa: PLC0415 - not needed if only submodules are imported

    return load(__name__, _EXPORTS, name)


def __dir__() -> list[str]:
    """Return all public names, loaded or not, for completion."""
    from pyros1.ground.lazy import public_names  # noqa: PLC0415 - most programs never call this

    return public_names(globals(), __all__)
