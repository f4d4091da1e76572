"""Reads descriptions of robots (URDF). Pure.

Nothing is fetched from outside the text, and there are no entities (defusedxml). Elements that do not affect the poses
of links, such as visual and transmission, are ignored.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import isfinite, sqrt
from xml.etree.ElementTree import Element, ParseError

from pyros1.ground.suggest import did_you_mean
from pyros1.ground.terminal_text import one_line
from pyros1.tf.rotation import IDENTITY, Transform, Vector, from_angles
from pyros1.urdf.model import MOVING, TYPES, Joint, Limit, Mimic, Robot, UrdfError, limit_warnings

MAX_LENGTH = 64 << 20
"""Maximum number of characters of a description."""
MAX_JOINTS = 100_000
_MAX_HINT_NAMES = 1_000
"""Maximum number of names that a misspelt one is compared with."""
_MAX_HINTS = 5
"""Maximum number of misspelt names that are compared, if they only cause warnings."""
_SPACE = "{http://www.ros.org/wiki/xacro}"


def read(text: str) -> Robot:
    """Read a description.

    Args:
        text: the parameter robot_description.

    Raises:
        UrdfError: it is not URDF, or an element is wrong.
    """
    root = _parse(text)
    links = _links(root)
    elements = root.findall("joint")
    if len(elements) > MAX_JOINTS:
        raise UrdfError(f"a robot has at most {MAX_JOINTS} joints")
    warnings: list[str] = []
    joints: dict[str, Joint] = {}
    children: dict[str, str] = {}
    for element in elements:
        joint = _joint(element, warnings)
        if joint.name in joints:
            raise UrdfError(f"there are two joints {_quoted(joint.name)}: give one of them another name")
        for word, name in (("parent", joint.parent), ("child", joint.child)):
            if name not in links:
                hint = did_you_mean(name, list(links)[:_MAX_HINT_NAMES])
                raise UrdfError(
                    f"joint {_quoted(joint.name)}: its {word} {_quoted(name)} is not a link of the robot{hint}"
                )
        if joint.child in children:
            raise UrdfError(
                f"link {_quoted(joint.child)} is the child of two joints, {_quoted(children[joint.child])} and "
                f"{_quoted(joint.name)}: a link has one parent"
            )
        children[joint.child] = joint.name
        joints[joint.name] = joint
    _check_mimics(joints, warnings)
    return Robot(root.get("name", ""), tuple(links), joints, tuple(limit_warnings(warnings)))


def _parse(text: str) -> Element:
    from defusedxml.common import DefusedXmlException  # type: ignore[import-untyped] # noqa: PLC0415 - not for --help
    from defusedxml.ElementTree import fromstring  # type: ignore[import-untyped] # noqa: PLC0415

    if len(text) > MAX_LENGTH:
        raise UrdfError(f"the description has {len(text)} characters, more than {MAX_LENGTH}")
    try:
        root: Element = fromstring(text)
    except (ParseError, DefusedXmlException, ValueError, LookupError) as error:
        hint = "; is it xacro? Then: xacro FILE.xacro" if "xacro:" in text else ""
        raise UrdfError(f"the description is not readable XML: {_quoted(str(error))}{hint}") from None
    if root.tag == "COLLADA" or root.tag.endswith("}COLLADA"):
        raise UrdfError("the description is COLLADA, which is not supported for robots: convert it to URDF")
    if root.tag != "robot":
        raise UrdfError(f"the description begins with <{_quoted(root.tag)}>, where URDF has <robot>")
    if any(str(element.tag).startswith(_SPACE) for element in root):
        raise UrdfError("the description is xacro, not URDF: set the parameter to the output of xacro FILE.xacro")
    return root


def _links(root: Element) -> dict[str, None]:
    links: dict[str, None] = {}
    for element in root.findall("link"):
        name = element.get("name", "")
        if not name:
            raise UrdfError("a link has no name: <link name=...>")
        if name in links:
            raise UrdfError(f"there are two links {_quoted(name)}: give one of them another name")
        links[name] = None
    if not links:
        raise UrdfError("the robot has no links: <link name=...>")
    return links


def _joint(element: Element, warnings: list[str]) -> Joint:
    name = element.get("name", "")
    if not name:
        raise UrdfError("a joint has no name: <joint name=... type=...>")
    what = f"joint {_quoted(name)}"
    kind = element.get("type", "")
    if kind not in TYPES:
        raise UrdfError(f"{what}: its type is {_quoted(kind)}; there are {', '.join(sorted(TYPES))}")
    ends = []
    for word in ("parent", "child"):
        end = element.find(word)
        link = "" if end is None else end.get("link", "")
        if not link:
            raise UrdfError(f"{what} has no {word}: <{word} link=.../>")
        ends.append(link)
    limit = _limit(element, what)
    if limit is None and kind in ("revolute", "prismatic"):
        raise UrdfError(
            f"{what} is {kind} and has no limit: <limit lower=... upper=... effort=... velocity=.../>"
            + (", or make it continuous" if kind == "revolute" else "")
        )
    axis = _axis(element, what) if kind in MOVING else (1.0, 0.0, 0.0)
    if axis == (0.0, 0.0, 0.0):
        warnings.append(f"{what} has the axis 0 0 0: it does not move")
    mimic = _mimic(element, what) if kind in MOVING else None
    return Joint(name, kind, ends[0], ends[1], _origin(element, what), axis, limit, mimic)


def _origin(element: Element, what: str) -> Transform:
    origin = element.find("origin")
    if origin is None:
        return IDENTITY
    x, y, z = _vector(origin, "xyz", what)
    roll, pitch, yaw = _vector(origin, "rpy", what)
    return (x, y, z, *from_angles(roll, pitch, yaw))


def _axis(element: Element, what: str) -> Vector:
    axis = element.find("axis")
    if axis is None or axis.get("xyz") is None:
        return (1.0, 0.0, 0.0)
    x, y, z = _vector(axis, "xyz", what)
    largest = max(abs(x), abs(y), abs(z)) or 1.0
    x, y, z = x / largest, y / largest, z / largest
    length = sqrt(x * x + y * y + z * z) or 1.0
    return (x / length, y / length, z / length)


def _limit(element: Element, what: str) -> Limit | None:
    limit = element.find("limit")
    if limit is None:
        return None
    safety = element.find("safety_controller")
    soft: list[float | None] = [None, None]
    if safety is not None:
        words = ("soft_lower_limit", "soft_upper_limit")
        soft = [_number(safety, word, what, 0.0) if safety.get(word) is not None else None for word in words]
    return Limit(_number(limit, "lower", what, 0.0), _number(limit, "upper", what, 0.0), soft[0], soft[1])


def _mimic(element: Element, what: str) -> Mimic | None:
    mimic = element.find("mimic")
    if mimic is None:
        return None
    joint = mimic.get("joint", "")
    if not joint:
        raise UrdfError(f"{what}: its mimic names no joint: <mimic joint=.../>")
    return Mimic(joint, _number(mimic, "multiplier", what, 1.0), _number(mimic, "offset", what, 0.0))


def _check_mimics(joints: dict[str, Joint], warnings: list[str]) -> None:
    checked: set[str] = set()
    for name in joints:
        path: dict[str, None] = {}
        each = joints.get(name)
        while each is not None and each.mimic is not None and each.name not in checked:
            if each.name in path:
                raise UrdfError(f"joint {_quoted(name)} follows itself, by way of mimic: {_names(path)}")
            path[each.name] = None
            leader = joints.get(each.mimic.joint)
            if leader is None or leader.type not in MOVING:
                hint = f": it is {leader.type}" if leader else ""
                if leader is None and len(warnings) < _MAX_HINTS:  # comparing names is slow
                    hint = did_you_mean(each.mimic.joint, list(joints)[:_MAX_HINT_NAMES])
                warnings.append(
                    f"joint {_quoted(each.name)} mimics {_quoted(each.mimic.joint)}, which is not a movable joint{hint}"
                )
            each = leader
        checked.update(path)


def _vector(element: Element, word: str, what: str) -> Vector:
    text = element.get(word)
    if text is None:
        return (0.0, 0.0, 0.0)
    numbers = [_float(part) for part in text.split()[:4]]
    if len(numbers) != 3 or None in numbers:
        raise UrdfError(f'{what}: <{element.tag} {word}="{_quoted(text)}"> must be three numbers')
    x, y, z = (part or 0.0 for part in numbers)
    return (x, y, z)


def _number(element: Element, word: str, what: str, default: float) -> float:
    text = element.get(word)
    if text is None:
        return default
    number = _float(text)
    if number is None:
        raise UrdfError(f'{what}: <{element.tag} {word}="{_quoted(text)}"> must be a number')
    return number


def _float(text: str) -> float | None:
    try:
        number = float(text)
    except ValueError:
        return None
    return number if isfinite(number) and "_" not in text else None


def _names(names: Iterable[str]) -> str:
    return ", ".join(_quoted(name) for name in list(names)[:10])


def _quoted(name: str) -> str:
    return one_line(name, 200)
