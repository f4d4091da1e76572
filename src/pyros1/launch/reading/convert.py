"""Converts strings in launch files to typed values: parameters and booleans (X41, X55, X74).

The types are those of https://wiki.ros.org/roslaunch/XML/param.
"""

from __future__ import annotations

from typing import Any

from pyros1.ground.errors import LaunchError


def convert_value(text: str, type_name: str) -> Any:  # noqa: PLR0911 - one for each type
    """Convert a string to a parameter's value.

    Args:
        text: the string, after substitution.
        type_name: the type in lower case: ``auto``, ``str``, ``string``, ``int``, ``double``, ``bool``, ``boolean`` or
            ``yaml``.

    Returns:
        The value.

    Raises:
        LaunchError: the string cannot be converted to this type, or the type is unknown.
    """
    if type_name in ("str", "string"):
        return text
    stripped = text.strip()
    if type_name == "auto":
        return _convert_automatically(text, stripped)
    if type_name in ("bool", "boolean"):
        if stripped.lower() in ("true", "1"):
            return True
        if stripped.lower() in ("false", "0"):
            return False
        raise LaunchError(f"{text} is not a '{type_name}' type")
    if type_name == "yaml":
        from pyros1.values import YamlError, load_yaml  # noqa: PLC0415 - rarely used

        try:
            return load_yaml(text)
        except YamlError as error:
            raise LaunchError(f"cannot convert to type [yaml]: {error}") from error
    try:
        if type_name == "int":
            return int(stripped)
        if type_name == "double":
            return float(stripped)
    except ValueError as error:
        raise LaunchError(f"cannot convert [{text}] to type [{type_name}]: {error}") from error
    raise LaunchError(f"Unknown type '{type_name}'")


def _convert_automatically(text: str, stripped: str) -> Any:
    try:
        if "." in stripped:
            return float(stripped)
        if "_" not in stripped:  # 1_000 is a number in Python, but not in roslaunch
            return int(stripped)
    except ValueError:
        pass
    if text.lower() in (
        "true",
        "false",
    ):  # not stripped: text from a command or file ends with a newline
        return text.lower() == "true"
    return text


def convert_bool(text: str, attribute: str) -> bool:
    """Parse an attribute that must be true or false.

    Args:
        text: the attribute's value, after substitution.
        attribute: the attribute's name, for error messages.

    Raises:
        LaunchError: the value is neither true nor false.
    """
    lowered = text.lower()
    if lowered not in ("true", "false"):
        raise LaunchError(f"invalid boolean value for [{attribute}]: {text!r}; it must be true or false")
    return lowered == "true"


def convert_condition(text: str) -> bool:
    """Parse the value of ``if`` or ``unless``: true, 1, false or 0, in upper or lower case.

    Raises:
        LaunchError: the value is something else.
    """
    lowered = text.lower().strip()
    if lowered in ("true", "1"):
        return True
    if lowered in ("false", "0"):
        return False
    raise LaunchError(f"{text} is not a 'bool' type")
