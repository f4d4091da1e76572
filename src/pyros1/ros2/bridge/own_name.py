"""The name of a bridge's node in ROS 2. All bridges of a master have the same name, and no others do, so they recognise
each other by it, and ignore each other's messages.
"""

from __future__ import annotations

import hashlib

from pyros1.ground.errors import ParameterNotSetError
from pyros1.net.master_client import MasterClient


def own_name(master: MasterClient) -> str:
    """Return the name. It changes when the master is started again, since another master may then have its address.

    Args:
        master: asks the master.

    Raises:
        Error: the master does not respond.
    """
    try:
        id_ = str(master.get_param("/run_id"))
    except ParameterNotSetError:
        id_ = master.uri  # only roscore sets the parameter
    return f"pyros1_bridge_{hashlib.sha256(id_.encode()).hexdigest()[:8]}"
