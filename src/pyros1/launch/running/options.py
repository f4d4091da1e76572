"""The options of a launch."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass
class Options:
    """The options of a launch.

    Attributes:
        core: whether to run only a core; if so, it is an error if a master is already running.
        port: port for a master started by this launch; None for the port in ROS_MASTER_URI.
        run_id: the run id, which must equal the master's run id; None to use the master's, or a new one.
        screen: whether to send all output to the screen (True) or to log files (False); None for each node's setting.
        required: whether to make every node required.
        local: whether to skip nodes on other machines.
        wait: whether to wait for a master instead of starting one.
        show_summary: whether to print the SUMMARY block.
        sigint_timeout: seconds between SIGINT and SIGTERM.
        sigterm_timeout: seconds between SIGTERM and SIGKILL.
        title: beginning of the terminal's title.
        notify_timeout: maximum number of seconds that a master started by this launch waits for a node to respond; None
            for the default.
        prefix: whether to print the node's name before each line of its output on the screen.
        master_log_level: minimum level in the log of a master started by the launch: debug, info, warn, error or fatal.
        keep_running: whether to continue when no process is left, as a core does.
        preload: whether to start Python nodes by forking a process that has already imported pyros1.
        journal: whether the core has a journal, and restores the state of a core that was killed.
    """

    core: bool = False
    port: int | None = None
    run_id: str | None = None
    screen: bool | None = None
    required: bool = False
    local: bool = False
    wait: bool = False
    show_summary: bool = True
    sigint_timeout: float = 15.0
    sigterm_timeout: float = 2.0
    title: str = "roslaunch"
    notify_timeout: float | None = None
    prefix: bool = False
    master_log_level: str = "info"
    keep_running: bool = False
    preload: bool = False
    journal: bool = False
