"""How a launch is to run, apart from what is launched."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass
class Options:
    """How to launch.

    Attributes:
        core: run a core only; another master is an error.
        port: port of a master that is started here, None for that of ROS_MASTER_URI.
        run_id: a run id that must be the master's.
        screen: all output to the screen (True), to log files (False), or as each node says (None).
        required: every node is required.
        local: leave out nodes of other machines.
        wait: wait for a master instead of starting one.
        show_summary: print the SUMMARY block.
        show_title: set the terminal's title.
        sigint_timeout: seconds between SIGINT and SIGTERM.
        sigterm_timeout: seconds between SIGTERM and SIGKILL.
        title: what the terminal's title begins with.
        notify_timeout: seconds nodes have to answer a master started here.
        prefix: write the node's name before each line on the screen.
        master_log_level: least level in the log of a master started here: debug, info, warn, error or fatal.
        keep_running: go on when no process is left (a core always does).
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
