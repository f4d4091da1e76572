"""An sshd on the loopback, with keys and a client configuration made for one test."""

from __future__ import annotations

import contextlib
import getpass
import os
import shutil
import socket
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from harness import free_port, until

SSHD = shutil.which("sshd", path=f"{os.environ['PATH']}:/usr/sbin")
SERVER = """
Port {port}
ListenAddress {address}
HostKey {folder}/host_key
AuthorizedKeysFile {folder}/user_key.pub
StrictModes no
UsePAM no
PidFile none
"""
CLIENT = """
Host robot localhost
  HostName {address}
  Port {port}
  User {user}
  IdentityFile {folder}/user_key
  IdentitiesOnly yes
  UserKnownHostsFile {folder}/.ssh/known_hosts
  BatchMode yes
"""


def prepare(folder: Path, address: str, port: int, more: str = "") -> list[str]:
    """Return the command line of an sshd; ``folder`` gets what ssh needs to reach "robot", as a HOME would have it.

    Args:
        folder: an empty one; ``.ssh/config`` and ``.ssh/known_hosts`` are made in it.
        address: where it listens.
        port: its port.
        more: more lines for its configuration.
    """
    if SSHD is None:
        pytest.fail("there is no sshd; run interop/setup")
    (folder / ".ssh").mkdir(mode=0o700)
    for key in ("host_key", "user_key"):
        subprocess.run(["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", str(folder / key)], check=True)
    host_key = (folder / "host_key.pub").read_text()
    # Stock roslaunch looks for the host alone first.
    (folder / ".ssh" / "known_hosts").write_text(f"[{address}]:{port} {host_key}{address} {host_key}")
    (folder / "sshd_config").write_text(SERVER.format(address=address, port=port, folder=folder) + more)
    client = CLIENT.format(address=address, port=port, folder=folder, user=getpass.getuser())
    (folder / ".ssh" / "config").write_text(client)
    if os.geteuid() == 0:
        os.makedirs("/run/sshd", mode=0o755, exist_ok=True)
    return [SSHD, "-D", "-e", "-f", str(folder / "sshd_config")]


@contextlib.contextmanager
def loopback_sshd(folder: Path) -> Iterator[int]:
    """Run an sshd and yield its port; for the folder see `prepare`."""
    port = free_port()
    command = prepare(folder, "127.0.0.1", port)
    with (folder / "sshd.log").open("w") as log:
        server = subprocess.Popen(command, stdout=log, stderr=log)

    def answers() -> bool:
        assert server.poll() is None, (folder / "sshd.log").read_text()
        with socket.socket() as probe:
            return probe.connect_ex(("127.0.0.1", port)) == 0

    try:
        until(answers, "sshd listens")
        yield port
    finally:
        server.terminate()
        server.wait(10)
