"""Reads robot descriptions in the URDF format (no I/O).

Descriptions are untrusted: nothing outside the text is accessed, and defusedxml rejects XML entities. Elements that do
not affect the poses of links, such as visual and transmission, are ignored.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import isfinite, sqrt
from xml.etree.ElementTree import Element, ParseError

from pyros1.ground.suggest import did_you_mean
from pyros1.ground.terminal_text import one_line
from pyros1.tf.rotation import IDENTITY, Transform, Vector, from_angles
from pyros1.urdf.model import JOINT_TYPES, MOVING_TYPES, Joint, Limit, Mimic, Robot, UrdfError, truncate_warnings

MAX_DESCRIPTION_LENGTH = 64 << 20
"""Maximum number of characters in a description."""
MAX_JOINTS = 100_000
_MAX_HINT_NAMES = 1_000
"""Maximum number of names with which an unknown name is compared, to suggest the intended one."""
_MAX_HINTS = 5
"""Maximum number of warnings about unknown names that also suggest the intended name."""
_XACRO_NAMESPACE = "{http://www.ros.org/wiki/xacro}"


def read_robot(text: str) -> Robot:
    """Read a robot description.

    Args:
        text: the URDF: the value of the parameter robot_description.

    Raises:
        UrdfError: the text is not URDF, or an element is invalid.
    """
    root = _parse(text)
    links = _read_links(root)
    elements = root.findall("joint")
    if len(elements) > MAX_JOINTS:
        raise UrdfError(f"the robot has more than {MAX_JOINTS} joints")
    warnings: list[str] = []
    joints: dict[str, Joint] = {}
    children: dict[str, str] = {}
    for element in elements:
        joint = _read_joint(element, warnings)
        if joint.name in joints:
            raise UrdfError(f"there are two joints {_escaped(joint.name)}: rename one of them")
        for attribute, name in (("parent", joint.parent), ("child", joint.child)):
            if name not in links:
                hint = did_you_mean(name, list(links)[:_MAX_HINT_NAMES])
                raise UrdfError(
                    f"joint {_escaped(joint.name)}: its {attribute} {_escaped(name)} is not a link of the robot{hint}"
                )
        if joint.child in children:
            raise UrdfError(
                f"link {_escaped(joint.child)} is the child of two joints, {_escaped(children[joint.child])} and "
                f"{_escaped(joint.name)}: a link can have only one parent"
            )
        children[joint.child] = joint.name
        joints[joint.name] = joint
    _check_mimics(joints, warnings)
    return Robot(root.get("name", ""), tuple(links), joints, tuple(truncate_warnings(warnings)))


def _parse(text: str) -> Element:
    from defusedxml.common import DefusedXmlException  # type: ignore[import-untyped] # noqa: PLC0415 - not for --help
    from defusedxml.ElementTree import fromstring  # type: ignore[import-untyped] # noqa: PLC0415

    if len(text) > MAX_DESCRIPTION_LENGTH:
        raise UrdfError(f"the description has {len(text)} characters, more than {MAX_DESCRIPTION_LENGTH}")
    try:
        root: Element = fromstring(text)
    except (ParseError, DefusedXmlException, ValueError, LookupError) as error:
        hint = "; is it xacro? Then: xacro FILE.xacro" if "xacro:" in text else ""
        raise UrdfError(f"the description is not readable XML: {_escaped(str(error))}{hint}") from None
    if root.tag == "COLLADA" or root.tag.endswith("}COLLADA"):
        raise UrdfError("the description is COLLADA, which is not supported for robots: convert it to URDF")
    if root.tag != "robot":
        raise UrdfError(f"the root element is <{_escaped(root.tag)}>, but in URDF it is <robot>")
    if any(str(element.tag).startswith(_XACRO_NAMESPACE) for element in root):
        raise UrdfError("the description is xacro, not URDF: set the parameter to the output of xacro FILE.xacro")
    return root


def _read_links(root: Element) -> dict[str, None]:
    links: dict[str, None] = {}
    for element in root.findall("link"):
        name = element.get("name", "")
        if not name:
            raise UrdfError("a link has no name: <link name=...>")
        if name in links:
            raise UrdfError(f"two links are named '{_escaped(name)}': rename one of them")
        links[name] = None
    if not links:
        raise UrdfError("the robot has no links: add at least one <link name=...>")
    return links


def _read_joint(element: Element, warnings: list[str]) -> Joint:
    name = element.get("name", "")
    if not name:
        raise UrdfError("a joint has no name: <joint name=... type=...>")
    context = f"joint {_escaped(name)}"
    joint_type = element.get("type", "")
    if joint_type not in JOINT_TYPES:
        raise UrdfError(
            f"{context}: its type is {_escaped(joint_type)}; valid types are {', '.join(sorted(JOINT_TYPES))}"
        )
    links = []
    for attribute in ("parent", "child"):
        link_element = element.find(attribute)
        link = "" if link_element is None else link_element.get("link", "")
        if not link:
            raise UrdfError(f"{context} has no {attribute}: <{attribute} link=.../>")
        links.append(link)
    limit = _read_limit(element, context)
    if limit is None and joint_type in ("revolute", "prismatic"):
        raise UrdfError(
            f"{context} is {joint_type} but has no <limit>: add <limit lower=... upper=... effort=... velocity=.../>"
            + (", or make the joint continuous" if joint_type == "revolute" else "")
        )
    axis = _read_axis(element, context) if joint_type in MOVING_TYPES else (1.0, 0.0, 0.0)
    if axis == (0.0, 0.0, 0.0):
        warnings.append(f"{context} has the axis 0 0 0: the joint does not move")
    mimic = _read_mimic(element, context) if joint_type in MOVING_TYPES else None
    return Joint(name, joint_type, links[0], links[1], _read_origin(element, context), axis, limit, mimic)


def _read_origin(element: Element, context: str) -> Transform:
    origin = element.find("origin")
    if origin is None:
        return IDENTITY
    x, y, z = _read_vector(origin, "xyz", context)
    roll, pitch, yaw = _read_vector(origin, "rpy", context)
    return (x, y, z, *from_angles(roll, pitch, yaw))


def _read_axis(element: Element, context: str) -> Vector:
    axis = element.find("axis")
    if axis is None or axis.get("xyz") is None:
        return (1.0, 0.0, 0.0)
    x, y, z = _read_vector(axis, "xyz", context)
    largest = max(abs(x), abs(y), abs(z)) or 1.0
    x, y, z = x / largest, y / largest, z / largest
    length = sqrt(x * x + y * y + z * z) or 1.0
    return (x / length, y / length, z / length)


def _read_limit(element: Element, context: str) -> Limit | None:
    limit = element.find("limit")
    if limit is None:
        return None
    safety = element.find("safety_controller")
    soft_limits: list[float | None] = [None, None]
    if safety is not None:
        attributes = ("soft_lower_limit", "soft_upper_limit")
        soft_limits = [
            _read_number(safety, attribute, context, 0.0) if safety.get(attribute) is not None else None
            for attribute in attributes
        ]
    return Limit(
        _read_number(limit, "lower", context, 0.0),
        _read_number(limit, "upper", context, 0.0),
        soft_limits[0],
        soft_limits[1],
    )


def _read_mimic(element: Element, context: str) -> Mimic | None:
    mimic = element.find("mimic")
    if mimic is None:
        return None
    joint = mimic.get("joint", "")
    if not joint:
        raise UrdfError(f"{context}: its mimic element has no joint: <mimic joint=.../>")
    return Mimic(joint, _read_number(mimic, "multiplier", context, 1.0), _read_number(mimic, "offset", context, 0.0))


def _check_mimics(joints: dict[str, Joint], warnings: list[str]) -> None:
    checked: set[str] = set()
    for name in joints:
        path: dict[str, None] = {}
        current = joints.get(name)
        while current is not None and current.mimic is not None and current.name not in checked:
            if current.name in path:
                raise UrdfError(f"joint {_escaped(name)} follows itself through mimic tags: {_join_names(path)}")
            path[current.name] = None
            leader = joints.get(current.mimic.joint)
            if leader is None or leader.type not in MOVING_TYPES:
                hint = f": it is {leader.type}" if leader else ""
                if leader is None and len(warnings) < _MAX_HINTS:  # comparing names is slow
                    hint = did_you_mean(current.mimic.joint, list(joints)[:_MAX_HINT_NAMES])
                relation = f"joint {_escaped(current.name)} mimics {_escaped(current.mimic.joint)}"
                warnings.append(f"{relation}, which is not a movable joint{hint}")
            current = leader
        checked.update(path)


def _read_vector(element: Element, attribute: str, context: str) -> Vector:
    text = element.get(attribute)
    if text is None:
        return (0.0, 0.0, 0.0)
    numbers = [_parse_float(part) for part in text.split()[:4]]
    if len(numbers) != 3 or None in numbers:
        raise UrdfError(f'{context}: <{element.tag} {attribute}="{_escaped(text)}"> must be three numbers')
    x, y, z = (part or 0.0 for part in numbers)
    return (x, y, z)


def _read_number(element: Element, attribute: str, context: str, default: float) -> float:
    text = element.get(attribute)
    if text is None:
        return default
    number = _parse_float(text)
    if number is None:
        raise UrdfError(f'{context}: <{element.tag} {attribute}="{_escaped(text)}"> must be a number')
    return number


def _parse_float(text: str) -> float | None:
    try:
        number = float(text)
    except ValueError:
        return None
    return number if isfinite(number) and "_" not in text else None


def _join_names(names: Iterable[str]) -> str:
    return ", ".join(_escaped(name) for name in list(names)[:10])


def _escaped(name: str) -> str:
    return one_line(name, 200)
