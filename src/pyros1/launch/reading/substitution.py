"""Replaces ``$(arg x)`` and similar in attribute values
(https://wiki.ros.org/roslaunch/XML#substitution_args, X70-X73).

Everything except ``find`` is replaced first, then ``find``; so ``$(find pkg)/$(arg file)`` works, but nesting does not.
``$(eval ...)`` must be the whole value. ``$(`` cannot be escaped; any other ``$`` is an ordinary character.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import LaunchError
from pyros1.ground.suggest import did_you_mean
from pyros1.launch.reading.convert import convert_value

if TYPE_CHECKING:
    from pyros1.launch.reading.scope import ScopeSubstituter

MAX_GROWTH = 1 << 18
"""Maximum number of characters that substitutions may add to a value. Without a limit, an argument that contains
another argument ten times, which in turn contains a third one ten times, and so on, would exhaust the memory. The
system limits the length of a program's argument to half as many characters anyway."""

_COMMANDS = ("find", "env", "optenv", "dirname", "anon", "arg")


def substitute(text: str, source: ScopeSubstituter) -> str:
    """Replace all substitutions in `text`.

    Args:
        text: an attribute's value, or YAML text with ``subst_value``.
        source: provides the values to insert.

    Returns:
        The text with all substitutions replaced.

    Raises:
        LaunchError: a substitution is unknown or nested, has the wrong number of arguments, or has no value.
    """
    if "$(" not in text:
        return text
    if text.startswith("$(eval ") and text.endswith(")"):
        return _evaluate(text[len("$(eval ") : -1], source)
    text = _replace(text, source, find_only=False)
    return _replace(text, source, find_only=True)


def _replace(text: str, source: ScopeSubstituter, *, find_only: bool) -> str:
    parts: list[str] = []
    position = 0
    budget = len(text) + MAX_GROWTH
    while True:
        start = text.find("$(", position)
        if start < 0:
            parts.append(text[position:])
            return "".join(parts)
        parts.append(text[position:start])
        end = text.find(")", start)
        position = end + 1 if end >= 0 else len(text)
        inner = text[start + 2 : end] if end >= 0 else text[start + 2 :]
        if "$" in inner:
            raise LaunchError(f"Dollar signs '$' cannot be inside of substitution args [{text[start:position]}]")
        if "(" in inner:
            raise LaunchError(f"Invalid left parenthesis '(' in substitution args [{text[start:position]}]")
        if end < 0 or not inner:  # not closed or empty, so it is ordinary text
            parts.append(text[start:position])
            continue
        words = inner.split()
        command = words[0] if words else ""
        if command not in _COMMANDS:
            raise LaunchError(_unknown_command_error(inner))
        if (command == "find") is not find_only:
            parts.append(text[start:position])
        elif command == "find":
            _check_count(words, 1)
            # Everything up to the next space is the path, which may contain another $(find).
            path, space, remaining = text[position:].partition(" ")
            text, position = source.find(words[1], path) + space + remaining, 0
        else:
            parts.append(_look_up(command, words, source))
            budget -= len(parts[-1])
            if budget < 0:
                raise LaunchError(f"the substitutions add more than {MAX_GROWTH} characters")


def _unknown_command_error(inner: str) -> str:
    if inner.split()[:1] == ["eval"]:
        return f"$(eval ...) must be the whole value: $({inner})"
    hint = "".join(did_you_mean(word, _COMMANDS) for word in inner.split(maxsplit=1)[:1])
    return f"Unknown substitution command [{inner}]. Valid commands are {list(_COMMANDS)}{hint}"


def _check_count(words: list[str], count: int) -> None:
    if len(words) != count + 1:
        raise LaunchError(f"$({words[0]} name) takes one argument [{' '.join(words)}]")


def _look_up(command: str, words: list[str], source: ScopeSubstituter) -> str:
    if command == "optenv":
        if len(words) < 2:
            raise LaunchError("$(optenv var) must specify an environment variable")
        return source.optional_env(words[1], " ".join(words[2:]))
    if command == "dirname":
        return source.dirname()
    _check_count(words, 1)
    lookup: dict[str, Callable[[str], str]] = {"env": source.env, "anon": source.anon, "arg": source.arg}
    return lookup[command](words[1])


def _convert(text: str) -> Any:
    return convert_value(text, "auto")


def _evaluate(expression: str, source: ScopeSubstituter) -> str:
    from pyros1.launch.reading.expression import evaluate  # noqa: PLC0415 - rarely needed, and it imports Python's parser

    functions: dict[str, Callable[..., Any]] = {
        "arg": lambda name: _convert(source.arg(str(name))),
        "env": lambda name: source.env(str(name)),
        "optenv": lambda name, default="": source.optional_env(str(name), str(default)),
        "find": lambda package: source.find(str(package), ""),
        "anon": lambda name: source.anon(str(name)),
        "dirname": source.dirname,
    }
    used_args = source.args().keys() & set(re.findall(r"\w+", expression))
    return evaluate(expression, {name: _convert(source.arg(name)) for name in used_args}, functions)
