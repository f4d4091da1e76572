"""The options of a launch."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass
class Options:
    """The options of a launch.

    Attributes:
        core: run a core only; another master is an error.
        port: port of a master that is started here, None for the port in ROS_MASTER_URI.
        run_id: the run id, which must be the same as the master's.
        screen: send all output to the screen (True), to log files (False), or as set for each node (None).
        required: make every node required.
        local: do not start nodes of other machines.
        wait: wait for a master instead of starting one.
        show_summary: print the SUMMARY block.
        show_title: set the terminal's title.
        sigint_timeout: seconds between SIGINT and SIGTERM.
        sigterm_timeout: seconds between SIGTERM and SIGKILL.
        title: beginning of the terminal's title.
        notify_timeout: seconds that a master started here waits for a node to answer.
        prefix: write the node's name before each line on the screen.
        master_log_level: lowest level in the log of a master started here: debug, info, warn, error or fatal.
        keep_running: continue when no process is left, like a core.
        preload: start Python nodes as forks of a process that has imported pyros1.
        journal: a core keeps a journal, and continues a core that was killed.
    """

    core: bool = False
    port: int | None = None
    run_id: str | None = None
    screen: bool | None = None
    required: bool = False
    local: bool = False
    wait: bool = False
    show_summary: bool = True
    show_title: bool = True
    sigint_timeout: float = 15.0
    sigterm_timeout: float = 2.0
    title: str = "roslaunch"
    notify_timeout: float | None = None
    prefix: bool = False
    master_log_level: str = "info"
    keep_running: bool = False
    preload: bool = False
    journal: bool = False
