"""The log levels of rosgraph_msgs/Log, and their names."""

from __future__ import annotations

DEBUG, INFO, WARN, ERROR, FATAL = 1, 2, 4, 8, 16
LEVELS = {"DEBUG": DEBUG, "INFO": INFO, "WARN": WARN, "ERROR": ERROR, "FATAL": FATAL}
LEVEL_NAMES = {level: name for name, level in LEVELS.items()}


def level_from_name(name: str) -> int:
    """Return the level for a name in upper or lower case; ``warning`` and ``critical`` are accepted as well.

    Raises:
        TypeError: ``name`` is not a str.
        ValueError: there is no such level.
    """
    if not isinstance(name, str):
        raise TypeError(f"a log level must be a str such as 'info', not {name!r:.80}")
    upper_name = name.upper()
    upper_name = {"WARNING": "WARN", "CRITICAL": "FATAL"}.get(upper_name, upper_name)
    if upper_name not in LEVELS:
        raise ValueError(f"{name!r} is not a log level: use one of {', '.join(LEVELS).lower()}")
    return LEVELS[upper_name]
