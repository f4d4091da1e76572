"""The parameters of ekf_localization_node. Pure.

See https://docs.ros.org/en/noetic/api/robot_localization/html/state_estimation_nodes.html.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, isfinite
from typing import Any, TypeGuard

import numpy as np

from pyros1.robot_nodes.robot_localization.control import Control
from pyros1.robot_nodes.robot_localization.motion import SIZE, Array
from pyros1.robot_nodes.robot_localization.sensors import Mask
from pyros1.robot_nodes.shared.parameters import PrivateParameters, is_number

DEFAULT_NOISE = (0.05, 0.05, 0.06, 0.03, 0.03, 0.06, 0.025, 0.025, 0.04, 0.01, 0.01, 0.02, 0.01, 0.01, 0.015)
"""The diagonal of the default process noise."""
MAX_SENSORS = 100
"""Maximum number of sensors of each kind."""

_DEFAULT_VARIANCE = 1e-9
_KINDS = ("odom", "pose", "twist", "imu")
_USED_BY_KIND = {"odom": slice(0, 12), "pose": slice(0, 6), "twist": slice(6, 12), "imu": slice(3, 15)}


@dataclass(frozen=True)
class SensorSettings:
    """The parameters of a sensor; their names begin with the sensor's name.

    Attributes:
        kind: odom, pose, twist or imu.
        name: such as ``odom0``.
        topic: the sensor's topic.
        mask: which of the 15 variables are used (15,).
        queue_size, nodelay: options of the subscription.
        differential, relative: whether to use the sensor's pose as a velocity, or relative to the first pose.
        pose_threshold, twist_threshold, acceleration_threshold: Mahalanobis distances at which a measurement is
            rejected.
        removes_gravity: whether to remove gravity from its accelerations.
    """

    kind: str
    name: str
    topic: str
    mask: Mask
    queue_size: int
    nodelay: bool
    differential: bool
    relative: bool
    pose_threshold: float
    twist_threshold: float
    acceleration_threshold: float
    removes_gravity: bool


@dataclass(frozen=True)
class Settings:
    """The parameters of the node; `read_settings` lists their names.

    Attributes:
        world_frame, map_frame, odom_frame, base_frame: names of frames.
        control: the limits for ``use_control``, or None.
        initial_state, initial_covariance, process_noise: (15,), (15, 15), (15, 15).
        history: the length of the history in seconds; 0 for none.
    """

    sensors: tuple[SensorSettings, ...]
    frequency: float
    sensor_timeout: float
    flat: bool
    world_frame: str
    map_frame: str
    odom_frame: str
    base_frame: str
    transform_time_offset: float
    transform_timeout: float
    publishes_tf: bool
    inverts_tf: bool
    publishes_acceleration: bool
    publishes_corrections: bool
    diagnostics: bool
    gravity: float
    control: Control | None
    stamped_control: bool
    history: float
    resets_on_time_jump: bool
    predicts_to_now: bool
    dynamic_noise: bool
    process_noise: Array
    initial_covariance: Array
    initial_state: Array
    starts_disabled: bool


def read_settings(parameters: PrivateParameters, prefix: str = "") -> Settings:
    """Read the parameters.

    Args:
        parameters: the node's private parameters, which also report invalid values.
        prefix: the ``tf_prefix`` for the names of the frames.
    """
    frequency = parameters.number("frequency", 30.0, 0.01, 10_000.0)
    sensor_timeout = parameters.number("sensor_timeout", 1.0 / frequency, 0.0)
    odom_frame = parameters.text("odom_frame", "odom")
    frames = {
        "map": parameters.text("map_frame", "map"),
        "odom": odom_frame,
        "base": parameters.text("base_link_frame", "base_link"),
        "world": parameters.text("world_frame", odom_frame),
    }
    frames = {key: prefixed(name, prefix) for key, name in frames.items()}
    smooths = parameters.flag("smooth_lagged_data", False)
    return Settings(
        sensors=tuple(sensor for kind in _KINDS for sensor in _read_sensors(parameters, kind)),
        frequency=frequency,
        sensor_timeout=sensor_timeout,
        flat=parameters.flag("two_d_mode", False),
        world_frame=frames["world"],
        map_frame=frames["map"],
        odom_frame=frames["odom"],
        base_frame=frames["base"],
        transform_time_offset=parameters.number("transform_time_offset", 0.0, -1e6, 1e6),
        transform_timeout=parameters.number("transform_timeout", 0.0, 0.0, 1e6),
        publishes_tf=parameters.flag("publish_tf", True),
        inverts_tf=parameters.flag("invert_tf", False),
        publishes_acceleration=parameters.flag("publish_acceleration", False),
        publishes_corrections=parameters.flag("permit_corrected_publication", False),
        diagnostics=parameters.flag("print_diagnostics", True),
        gravity=parameters.number("gravitational_acceleration", 9.80665),
        control=_read_control(parameters, sensor_timeout) if parameters.flag("use_control", False) else None,
        stamped_control=parameters.flag("stamped_control", False),
        history=parameters.number("history_length", 0.0, 0.0, 1e6) if smooths else 0.0,
        resets_on_time_jump=parameters.flag("reset_on_time_jump", False),
        predicts_to_now=parameters.flag("predict_to_current_time", False),
        dynamic_noise=parameters.flag("dynamic_process_noise_covariance", False),
        process_noise=_read_matrix(parameters, "process_noise_covariance", np.diag(DEFAULT_NOISE)),
        initial_covariance=_read_matrix(parameters, "initial_estimate_covariance", _DEFAULT_VARIANCE * np.eye(SIZE)),
        initial_state=_read_numbers(parameters, "initial_state", [0.0] * SIZE),
        starts_disabled=parameters.flag("disabled_at_startup", False),
    )


def prefixed(frame: str, prefix: str) -> str:
    """Return a frame's name with a tf_prefix, if there is one, and without leading slashes."""
    frame, prefix = frame.lstrip("/"), prefix.strip("/")
    return f"{prefix}/{frame}" if prefix and not frame.startswith(f"{prefix}/") else frame


def _read_sensors(parameters: PrivateParameters, kind: str) -> list[SensorSettings]:
    sensors = []
    for number in range(MAX_SENSORS):
        name = f"{kind}{number}"
        if parameters.value(name) is None:
            break
        topic = parameters.text(name, "")
        config = parameters.value(f"{name}_config")
        mask = np.array(_as_flags(config, SIZE) or [False] * SIZE)
        unused = np.ones(SIZE, bool)
        unused[_USED_BY_KIND[kind]] = False
        mask[unused] = False
        if not topic or not mask.any():
            expected = f"a list of {SIZE} bools, true for what to use of {name}"
            parameters.report_invalid(f"{name}_config", config, expected, f"nothing of {name}")
            continue
        sensors.append(_read_sensor(parameters, kind, name, topic, mask))
    return sensors


def _read_sensor(parameters: PrivateParameters, kind: str, name: str, topic: str, mask: Mask) -> SensorSettings:
    def threshold(part: str) -> float:
        return parameters.number(f"{name}_{part}rejection_threshold", inf, 0.0)

    alone = kind in ("pose", "twist")  # their messages have only one part, which is not in the parameter's name
    differential = parameters.flag(f"{name}_differential", False)
    twist_threshold = threshold("" if alone else "twist_")
    return SensorSettings(
        kind=kind,
        name=name,
        topic=topic,
        mask=mask,
        queue_size=parameters.integer(f"{name}_queue_size", 1, 0, 100_000),
        nodelay=parameters.flag(f"{name}_nodelay", False),
        differential=differential,
        relative=parameters.flag(f"{name}_relative", False) and not differential,
        pose_threshold=threshold("" if alone else "pose_"),
        twist_threshold=min(twist_threshold, threshold("angular_velocity_")) if kind == "imu" else twist_threshold,
        acceleration_threshold=threshold("linear_acceleration_"),
        removes_gravity=parameters.flag(f"{name}_remove_gravitational_acceleration", False),
    )


def _read_control(parameters: PrivateParameters, sensor_timeout: float) -> Control:
    acceleration_limits = _read_numbers(parameters, "acceleration_limits", [1.0] * 6)
    acceleration_gains = _read_numbers(parameters, "acceleration_gains", [1.0] * 6)
    return Control(
        used=np.array(_read_flags(parameters, "control_config", [False] * 6)),
        acceleration_limits=np.abs(acceleration_limits),
        deceleration_limits=np.abs(_read_numbers(parameters, "deceleration_limits", list(acceleration_limits))),
        acceleration_gains=np.abs(acceleration_gains),
        deceleration_gains=np.abs(_read_numbers(parameters, "deceleration_gains", list(acceleration_gains))),
        timeout=parameters.number("control_timeout", sensor_timeout, 0.0),
    )


def _read_flags(parameters: PrivateParameters, name: str, default: list[bool]) -> list[bool]:
    value = parameters.value(name)
    if value is None:
        return default
    flags = _as_flags(value, len(default))
    return (
        parameters.report_invalid(name, value, f"a list of {len(default)} bools", default) if flags is None else flags
    )


def _as_flags(value: object, size: int) -> list[bool] | None:
    if _is_list(value, size) and all(isinstance(flag, int) for flag in value):
        return [bool(flag) for flag in value]
    return None


def _read_numbers(parameters: PrivateParameters, name: str, default: list[float]) -> Array:
    value = parameters.value(name)
    numbers = _as_numbers(value, len(default))
    if numbers is None and value is not None:
        parameters.report_invalid(name, value, f"a list of {len(default)} numbers", default)
    return np.array(default if numbers is None else numbers)


def _read_matrix(parameters: PrivateParameters, name: str, default: Array) -> Array:
    value = parameters.value(name)
    numbers = _as_numbers(value, SIZE * SIZE)
    if numbers is not None:
        return np.array(numbers).reshape(SIZE, SIZE)
    if value is not None:
        parameters.report_invalid(name, value, f"a list of {SIZE * SIZE} numbers, row by row", "the default")
    return default


def _as_numbers(value: Any, length: int) -> list[float] | None:
    """Return a list of ``length`` numbers, or None. YAML reads 1e-9 (no dot) as a string; here it is a number."""
    if not _is_list(value, length):
        return None
    try:
        numbers = [float(item) for item in value if is_number(item) or isinstance(item, str)]
    except ValueError:
        return None
    return numbers if len(numbers) == length and all(map(isfinite, numbers)) else None


def _is_list(value: Any, length: int) -> TypeGuard[list[Any]]:
    return isinstance(value, list) and len(value) == length
