"""The description of a process to start and supervise."""

from __future__ import annotations

from dataclasses import dataclass, field

from pyros1.launch.plan import ExitPolicy


@dataclass
class ProcessSpec:
    """A process to start and supervise.

    Attributes:
        label: unique name, ``ns/name-<counter>``.
        node: full node name.
        words: command line.
        env: complete environment.
        cwd: working directory.
        log_base: path of its log files without ``.log``, None for no log files.
        to_screen: inherit stdout; otherwise stdout goes to ``<log_base>-stdout.log``.
        errors_to_file: without ``to_screen``, stderr goes to ``<log_base>-stderr.log``.
        exit_policy: whether it is started again, or the launch ends, when it ends.
        ends_launch: the launch ends when it ends, without a report: it is a test, or the ``on-death`` action of a
            required process.
        on_death: a process to start when this one has ended on its own; None for none.
        package: the node's package.
    """

    label: str
    node: str
    words: list[str]
    env: dict[str, str]
    cwd: str
    log_base: str | None = None
    to_screen: bool = True
    exit_policy: ExitPolicy = field(default_factory=ExitPolicy)
    ends_launch: bool = False
    on_death: ProcessSpec | None = None
    errors_to_file: bool = False
    package: str = ""
