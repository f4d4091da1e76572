"""Tools for testing nodes with pytest.

``pip install pyros1 pytest`` is enough: pytest finds the fixtures (the module ``pyros1_pytest``) automatically. ::

    def test_the_controller_brakes(ros_run, ros_node, ros_listen):
        forces = ros_listen("/force_cmd", "std_msgs/Float64")
        ros_run("my_robot", "controller.py")
        velocity = ros_node("test").advertise("/velocity", "std_msgs/Float64", latch=True)
        velocity.publish(data=2.0)
        assert forces.first(lambda force: force.data < 0, timeout=5)

No sleeps are needed: a wait ends as soon as its condition is met. If the condition is not met in time, the wait fails,
and the error message describes the state.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pyros1.testing.heard import Heard
    from pyros1.testing.programs import Program

__all__ = ["Heard", "Program"]

_EXPORTS = {"Heard": "pyros1.testing.heard", "Program": "pyros1.testing.programs"}


def __getattr__(name: str) -> Any:
    """Load and return a public name when it is first used: pytest loads this package in each of its runs."""
    from pyros1.ground.lazy import load  # noqa: PLC0415 - most imports never get here

    return load(__name__, _EXPORTS, name)


def __dir__() -> list[str]:
    """Return all public names, loaded or not, for completion."""
    from pyros1.ground.lazy import public_names  # noqa: PLC0415 - most imports never get here

    return public_names(globals(), __all__)
