"""The description of a process to start and supervise."""

from __future__ import annotations

from dataclasses import dataclass, field

from pyros1.launch.plan import ExitPolicy


@dataclass
class ProcessSpec:
    """A process to start and supervise.

    Attributes:
        label: unique name, ``ns/name-<counter>``.
        node: the node's full name.
        words: the command line.
        env: the complete environment.
        cwd: the working directory.
        log_base: path of the log files without ``.log``; None for no log files.
        to_screen: whether the process inherits stdout; otherwise, its output is written to ``<log_base>-stdout.log``.
        errors_to_file: whether, without ``to_screen``, stderr is written to ``<log_base>-stderr.log``.
        exit_policy: whether to restart the process, or to shut down the launch, when it exits.
        ends_launch: whether to shut down the launch when the process exits, without a report, because it is a test, or
            the ``on-death`` action of a required process.
        on_death_spec: the process to start when this process has exited without being stopped; None for no process.
        package: the node's package.
        priority: the real-time priority, 1 to 99; 0 for none.
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
    on_death_spec: ProcessSpec | None = None
    errors_to_file: bool = False
    package: str = ""
    priority: int = 0
