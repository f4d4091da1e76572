"""imu_filter_node: adds the orientation from Madgwick's filter to an IMU's messages.

See https://wiki.ros.org/imu_filter_madgwick.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from math import isfinite
from typing import Any

from pyros1.msgs.geometry_msgs.msg import Vector3, Vector3Stamped
from pyros1.node import Node
from pyros1.reconfigure import Parameters, Server
from pyros1.robot_nodes.imu_filter_madgwick.madgwick import MadgwickFilter, Settings
from pyros1.robot_nodes.imu_filter_madgwick.world import WorldFrame
from pyros1.robot_nodes.shared.imu_node import ImuFilterNode
from pyros1.robot_nodes.shared.imu_readings import Estimate, Reading, UnusableReadingError
from pyros1.robot_nodes.shared.parameters import PrivateParameters, is_number
from pyros1.robot_nodes.shared.program import run_node
from pyros1.tf.rotation import to_angles

DEFAULTS: Mapping[str, float] = {"gain": 0.1, "zeta": 0.0, "mag_bias_x": 0.0, "mag_bias_y": 0.0, "mag_bias_z": 0.0}
"""The parameters that can be changed with dynamic_reconfigure."""


class Madgwick:
    """The node imu_filter_node. The gains and the magnetic bias can be changed with dynamic_reconfigure.

    Args:
        node: the node.
    """

    def __init__(self, node: Node) -> None:
        parameters = PrivateParameters.of(node)
        settings = read_settings(parameters)
        self._filter = MadgwickFilter(settings)
        self._config: dict[str, float] = {}
        for name, default in DEFAULTS.items():
            self._config[name] = parameters.number(name, default)
            if parameters.value(name) is not None and not is_number(parameters.value(name)):
                node.params[f"~{name}"] = default  # the server would also report the invalid value
        self._server = Server(node, _make_parameters(), self._on_configured)
        debug = parameters.flag("publish_debug_topics", False)
        if debug:
            self._raw_angles = node.advertise(f"{node.resolve('imu')}/rpy/raw", Vector3Stamped, queue_size=5)
        self._running = ImuFilterNode(
            node,
            parameters,
            self._filter,
            use_mag=settings.use_mag,
            publish_tf=True,
            vector_field=not parameters.flag("use_magnetic_field_msg", True),
            watch=self._publish_raw if debug else None,
        )

    def _on_configured(self, config: Any, level: int) -> Any:
        for name, before in self._config.items():
            if not isfinite(config[name]):
                config[name] = before
            self._config[name] = config[name]
        gain, zeta, *mag_bias = self._config.values()
        self._filter.configure(gain, zeta, (mag_bias[0], mag_bias[1], mag_bias[2]))
        return config

    def _publish_raw(self, header: Any, reading: Reading, estimate: Estimate) -> None:
        if reading.field is not None:
            with suppress(UnusableReadingError):
                angles = to_angles(self._filter.measure(reading))
                self._raw_angles.publish(Vector3Stamped(header, Vector3(*angles)))


def read_settings(parameters: PrivateParameters) -> Settings:
    """Read the filter's parameters that do not change while it is running."""
    name = parameters.text("world_frame", "enu")
    if name not in {frame.value for frame in WorldFrame}:
        name = parameters.report_invalid("world_frame", name, "enu, ned or nwu", "enu")
    return Settings(
        world=WorldFrame(name),
        use_mag=parameters.flag("use_mag", True),
        yaw_offset=parameters.number("yaw_offset", 0.0) - parameters.number("declination", 0.0),
        stateless=parameters.flag("stateless", False),
        remove_gravity=parameters.flag("remove_gravity_vector", False),
    )


def _make_parameters() -> Parameters:
    parameters = Parameters()
    limits = {"gain": (0.0, 1.0, "how fast the accelerometer and the magnetic field are followed")}
    limits["zeta"] = -1.0, 1.0, "how fast drift of the gyroscope is corrected, about in rad/s"
    for name, default in DEFAULTS.items():
        minimum, maximum, text = limits.get(name, (-10.0, 10.0, "what the robot adds to the magnetic field"))
        parameters.add(name, default, text, minimum=minimum, maximum=maximum)
    return parameters


def main(argv: list[str]) -> int:
    """Run imu_filter_node; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    return run_node(argv, "ImuFilter", Madgwick)
