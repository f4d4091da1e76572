"""The hosts that the other tests here run on: they reach each other as real ones would, and leave nothing behind."""

from __future__ import annotations

import signal
import subprocess
import sys
import textwrap
from pathlib import Path

from harness import PEERS, until
from hosts import Host, Network

CONNECT = "import socket, sys; socket.create_connection((sys.argv[1], int(sys.argv[2])), 0.5)"
LISTEN = """
import socket
listener = socket.create_server(('', 7000))
while True:
    connection, address = listener.accept()
    print('from', address[0], flush=True)
"""


def reaches(host: Host, name: str, port: int = 7000) -> bool:
    return host.run([sys.executable, "-c", CONNECT, name, str(port)]).code == 0


def test_a_host_behind_nat_reaches_others_and_is_not_reached() -> None:
    with Network() as network:
        robot, laptop = network.add("robot"), network.add("laptop", behind_nat=True)
        for host in (robot, laptop):
            host.start([sys.executable, "-c", LISTEN], host.environ(), "listener")
            host.await_port(7000)
        assert reaches(laptop, "robot") and not reaches(robot, "laptop")
        robot.processes[0].wait_line("from 10.88.0.254")  # the router's address


def test_a_cut_and_a_firewall_end_with_what_undoes_them() -> None:
    with Network() as network:
        robot, laptop = network.add("robot"), network.add("laptop")
        robot.start([sys.executable, "-c", LISTEN], robot.environ(), "listener")
        robot.await_port(7000)
        assert reaches(laptop, "robot")
        network.cut(robot)
        assert not reaches(laptop, "robot")
        network.mend(robot)
        until(lambda: reaches(laptop, "robot"), "the plug is in again")
        robot.firewall("tcp dport 22 accept")
        assert not reaches(laptop, "robot")
        robot.firewall("tcp dport 7000 accept")
        assert reaches(laptop, "robot")
        laptop.forget("robot")
        assert not reaches(laptop, "robot") and reaches(laptop, robot.address)


def test_hosts_end_with_a_test_run_that_is_killed(tmp_path: Path) -> None:
    program = f"""
    import sys, time
    sys.path.insert(0, {str(PEERS)!r})
    from hosts import Network
    host = Network().add("robot")
    host.start(["sleep", "600"], host.environ())
    print(host.pid, host.processes[0].pid, flush=True)
    time.sleep(600)
    """
    environ = {"PATH": "/usr/sbin:/usr/bin:/sbin:/bin", "TMPDIR": str(tmp_path)}
    run = subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(program)], stdout=subprocess.PIPE, text=True, env=environ
    )
    assert run.stdout is not None
    with run.stdout:
        pids = [int(word) for word in run.stdout.readline().split()]
    assert len(pids) == 2
    run.send_signal(signal.SIGKILL)
    run.wait(10)
    until(lambda: not any(_runs(pid) for pid in pids), "the host and what ran there have ended", timeout=30)


def _runs(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False
