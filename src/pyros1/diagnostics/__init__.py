"""Diagnostics of a node, published on /diagnostics (REP 107, https://wiki.ros.org/diagnostics).

::

    import pyros1
    from pyros1.diagnostics import OK, WARN, Frequency, Updater

    def battery(status):
        status.summary(OK, "charged")
        status.add("Voltage", 12.4)

    with pyros1.Node("driver") as node:
        scans = Frequency(node.now, minimum=9.0, maximum=11.0)
        updater = Updater(node, hardware_id="laser 7")
        updater.add("Battery", battery)
        updater.add("Scans", scans.run)
        node.timer(0.1, lambda event: scans.tick())
        node.spin()
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pyros1.diagnostics.status import ERROR, OK, STALE, WARN, Status
    from pyros1.diagnostics.tasks import Combined, Frequency, TimeStamps, alive
    from pyros1.diagnostics.updater import Updater

__all__ = ["ERROR", "OK", "STALE", "WARN", "Combined", "Frequency", "Status", "TimeStamps", "Updater", "alive"]

_EXPORTS = {
    "ERROR": "pyros1.diagnostics.status",
    "OK": "pyros1.diagnostics.status",
    "STALE": "pyros1.diagnostics.status",
    "WARN": "pyros1.diagnostics.status",
    "Combined": "pyros1.diagnostics.tasks",
    "Frequency": "pyros1.diagnostics.tasks",
    "Status": "pyros1.diagnostics.status",
    "TimeStamps": "pyros1.diagnostics.tasks",
    "Updater": "pyros1.diagnostics.updater",
    "alive": "pyros1.diagnostics.tasks",
}


def __getattr__(name: str) -> Any:
    """Load and return a public name when it is first used."""
    from pyros1.ground.lazy import load  # noqa: PLC0415 - not needed if only submodules are imported

    return load(__name__, _EXPORTS, name)


def __dir__() -> list[str]:
    """Return all public names, loaded or not, for completion."""
    from pyros1.ground.lazy import public_names  # noqa: PLC0415 - most programs never call this

    return public_names(globals(), __all__)
