"""Changes the parameters of a chain's filters while the node is running (https://wiki.ros.org/dynamic_reconfigure).

As in stock ROS, each filter of these types has a server in the namespace ``~NAME``, with NAME as in the chain.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import pi
from typing import Any

from pyros1.ground.errors import Error
from pyros1.node import Node
from pyros1.reconfigure import Parameters, Server
from pyros1.robot_nodes.laser_filters.chain import make_filter
from pyros1.robot_nodes.laser_filters.scans import FilterError, ScanFilter
from pyros1.robot_nodes.shared.parameters import is_number
from pyros1.values.reading import YamlError, load_yaml

_LARGE = 100000.0
_MAX_POLYGON_LENGTH = 50_000  # reading longer ones as YAML would take seconds
_Entry = tuple[str, Any, Any, Any]  # name, default, minimum, maximum


def _box(axis: str) -> list[_Entry]:
    return [(f"min_{axis}", -1.0, -100.0, 100.0), (f"max_{axis}", 1.0, -100.0, 100.0)]


_INVERT: _Entry = ("invert", False, None, None)
_POLYGON: list[_Entry] = [("polygon", "[]", None, None), ("polygon_padding", 0.0, 0.0, 100.0), _INVERT]
PARAMETERS: Mapping[str, list[_Entry]] = {
    "LaserScanBoxFilter": [("box_frame", "base_link", None, None), *_box("x"), *_box("y"), *_box("z"), _INVERT],
    "LaserScanIntensityFilter": [
        ("lower_threshold", 8000.0, -1.0, _LARGE),
        ("upper_threshold", _LARGE, 0.0, _LARGE),
        _INVERT,
        ("filter_override_range", True, None, None),
        ("filter_override_intensity", False, None, None),
    ],
    "LaserScanPolygonFilter": _POLYGON,
    "LaserScanRangeFilter": [
        ("lower_threshold", 0.0, 0.0, _LARGE),
        ("upper_threshold", _LARGE, 0.0, _LARGE),
        ("use_message_range_limits", False, None, None),
        ("lower_replacement_value", 0.0, 0.0, _LARGE),
        ("upper_replacement_value", _LARGE, 0.0, _LARGE),
    ],
    "LaserScanSectorFilter": [
        ("angle_min", 0.0, -pi, pi),
        ("angle_max", 0.0, -pi, pi),
        ("range_min", 0.0, 0.0, _LARGE),
        ("range_max", _LARGE, 0.0, _LARGE),
        ("clear_inside", True, None, None),
        _INVERT,
    ],
    "LaserScanSpeckleFilter": [
        ("filter_type", 0, 0, 1),
        ("max_range", 2.0, 0.0, 100.0),
        ("max_range_difference", 0.4, 0.0, 100.0),
        ("filter_window", 4, 0, 100),
    ],
    "ScanShadowsFilter": [
        ("min_angle", 10.0, 0.0, 360.0),
        ("max_angle", 170.0, 0.0, 360.0),
        ("window", 1, 0, 100),
        ("neighbors", 20, 0, 100),
        ("remove_shadow_start_point", False, None, None),
    ],
    "StaticLaserScanPolygonFilter": _POLYGON,
}
"""The parameters that can be changed, by filter type: name, default, minimum and maximum."""


class FilterServer:
    """Lets other nodes change a filter's parameters. Parameters that are not changed keep the chain's values.

    Args:
        node: the node.
        filters: the chain, in which the filter is replaced.
        index: the filter's index in the chain.
        specification: the filter's name, type and params; the type must be in `PARAMETERS`.
        place: the name of the parameter with the specification, for messages.
        report: called with a one-line message about each parameter that cannot be used.

    Raises:
        Error: the name is invalid, or another filter has the same name.
    """

    def __init__(
        self,
        node: Node,
        filters: list[ScanFilter],
        index: int,
        specification: Mapping[str, Any],
        place: str,
        report: Callable[[str], object],
    ) -> None:
        self._filters, self._index = filters, index
        self._specification, self._place, self._report = specification, place, report
        self._params: dict[str, Any] = dict(specification.get("params") or {})
        self._last: dict[str, Any] = {}
        self._names = []
        parameters = Parameters()
        for name, default, minimum, maximum in PARAMETERS[_kind(specification)]:
            self._names.append(name)
            parameters.add(name, default, minimum=minimum, maximum=maximum)
            value = _to_type_of(self._params.get(name), default)
            # As in stock ROS, the chain's values are used, not changes from an earlier run.
            node.params[f"~{specification['name']}/{name}"] = default if value is None else value
        self._server = Server(node, parameters, self._change, specification["name"])

    def _change(self, config: Any, level: int) -> Any:
        values = {name: config[name] for name in self._names}
        changes = {name: value for name, value in values.items() if self._last and value != self._last[name]}
        if changes:
            try:
                params = {**self._params, **_parsed(changes)}
                made = make_filter({**self._specification, "params": params}, self._place, self._report)
            except FilterError as error:
                self._report(f"the filter is not changed: {error}")
                config.update(self._last)  # also tells the client
                return config
            self._params, self._filters[self._index] = params, made
        self._last = values
        return config


def serve_filters(
    node: Node, filters: list[ScanFilter], specifications: Any, place: str, report: Callable[[str], object]
) -> list[FilterServer]:
    """Create servers for the filters of a chain that can be changed and have a name.

    Args:
        node: the node.
        filters: the filters, which are replaced when they are changed.
        specifications: the chain from which the filters were created.
        place: the chain's parameter, for messages.
        report: called with a one-line message about each invalid parameter or name.
    """
    servers = []
    for index, each in enumerate(specifications or []):
        if _kind(each) not in PARAMETERS or not isinstance(each.get("name"), str):
            continue
        try:
            servers.append(FilterServer(node, filters, index, each, f"{place}[{index}] ({each['name']:.50})", report))
        except (Error, ValueError) as error:
            report(f"{place}[{index}] cannot be changed by dynamic_reconfigure: {error}")
    return servers


def _kind(specification: Mapping[str, Any]) -> str:
    return str(specification["type"]).rpartition("/")[2]


def _to_type_of(value: Any, default: Any) -> Any:
    """Convert a value in the chain to the type of the default; return None if that is not possible."""
    if isinstance(default, str):
        return str(value) if isinstance(value, (str, list)) else None
    if isinstance(default, bool):
        return value if isinstance(value, bool) else None
    if not is_number(value):
        return None
    return float(value) if isinstance(default, float) else round(value)


def _parsed(changes: Mapping[str, Any]) -> dict[str, Any]:
    """Convert changes from dynamic_reconfigure to parameters of a filter in the chain.

    Raises:
        FilterError: a polygon is not a list of corners, or too long.
    """
    if "polygon" not in changes:
        return dict(changes)
    if len(changes["polygon"]) > _MAX_POLYGON_LENGTH:
        raise FilterError(f"polygon is longer than {_MAX_POLYGON_LENGTH} characters")
    try:
        return {**changes, "polygon": load_yaml(changes["polygon"])}
    except YamlError as error:
        raise FilterError(f"polygon must be a list of corners: [[x, y], [x, y], [x, y]] ({error})") from None
