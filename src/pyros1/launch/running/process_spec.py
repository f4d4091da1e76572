"""What to start, and how to treat it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass
class ProcessSpec:
    """What to start and how to treat it.

    Attributes:
        label: unique name, ``ns/name-<counter>``.
        node: full node name.
        words: command line.
        env: whole environment.
        cwd: working directory.
        log_base: path of its log files without ``.log``, None for none.
        to_screen: inherit stdout; else it goes to ``<log_base>-stdout.log``.
        errors_to_file: stderr goes to ``<log_base>-stderr.log`` then, too.
        respawn: start it again whenever it ends.
        respawn_delay: seconds before that.
        required: everything ends when it ends.
        decisive: it is what everything is for: the end of it is no news.
    """

    label: str
    node: str
    words: list[str]
    env: dict[str, str]
    cwd: str
    log_base: str | None = None
    to_screen: bool = True
    respawn: bool = False
    respawn_delay: float = 0.0
    required: bool = False
    decisive: bool = False
    errors_to_file: bool = False
