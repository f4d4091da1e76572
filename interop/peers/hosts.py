"""Hosts on one machine, for tests of several machines: network namespaces with addresses, names and firewalls.

    with Network() as network:
        robot, laptop = network.add("robot"), network.add("laptop")
        uri = robot.core("stock")
        assert "/rosout" in laptop.run(laptop.pyros1("node", "list"), laptop.environ(uri)).output

It needs root, ``ip`` and ``nft``. Nothing is made outside the namespaces: no links, rules or files of the machine
change, and two networks never meet, though their addresses are the same. They end with the test, even if that is
killed: each host has a keeper, whose standard input ends then, and which kills whatever still runs there.
"""

from __future__ import annotations

import contextlib
import itertools
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import NamedTuple

from harness import DEADLINE, Peer, Process, child_environ, peer_command

# What holds a host's namespaces. It waits for the end of its input, kills all that run in the host, and ends.
_KEEPER = r"""
hostname "$1"
mount --bind "$2/hosts" /etc/hosts
mount --bind "$2/resolv.conf" /etc/resolv.conf
mount --bind "$2/nsswitch.conf" /etc/nsswitch.conf
ip link set lo up
trap '' INT TERM HUP
echo ready
read -r _ || true
mine=$(readlink /proc/self/ns/net | sed 's/[][]/\\&/g')
for again in 1 2 3; do
  find /proc/[0-9]*/ns/net -lname "$mine" ! -path "/proc/$$/*" | cut -d/ -f3 | xargs -r kill -9 || true
done 2>/dev/null
"""


class Ended(NamedTuple):
    """A command that ended: its exit code and what it printed, stdout before stderr."""

    code: int
    output: str


class Host:
    """A host: made by `Network.add`.

    Attributes:
        name: its host name, which all hosts of the network know.
        address: its IPv4 address.
        address6: its IPv6 address.
    """

    def __init__(self, name: str, address: str, address6: str, folder: Path) -> None:
        self.name = name
        self.address = address
        self.address6 = address6
        self.home = folder / name
        self.processes: list[Process] = []
        self.home.mkdir()
        (self.home / "hosts").write_text("127.0.0.1 localhost\n::1 localhost\n")
        # A name that is not in /etc/hosts is unknown at once: nobody listens there.
        (self.home / "resolv.conf").write_text("nameserver 127.0.0.1\noptions timeout:1 attempts:1\n")
        (self.home / "nsswitch.conf").write_text("passwd: files\ngroup: files\nhosts: files dns\n")
        unshare = ["unshare", "--net", "--uts", "--mount", "--propagation", _propagation()]
        self._keeper = subprocess.Popen(
            [*unshare, "sh", "-ec", _KEEPER, "keeper", name, str(self.home)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            start_new_session=True,  # Ctrl-C in the terminal of the tests is not for it
        )
        assert self._keeper.stdout is not None
        assert self._keeper.stdout.readline() == "ready\n", f"no namespaces for {name}: do the tests run as root?"

    @property
    def pid(self) -> int:
        """The process that holds its namespaces."""
        return self._keeper.pid

    def inside(self, command: Sequence[str]) -> list[str]:
        """The command that runs *command* in this host; its process becomes that of *command*, signals reach it."""
        return ["nsenter", f"--target={self.pid}", "--net", "--uts", "--mount", "--root", "--wd=/", "--", *command]

    def environ(self, uri: str = "", python: str = "ours", **extra: str | None) -> dict[str, str]:
        """The environment of a program: nothing of the developer's, neither ROS_IP nor ROS_HOSTNAME.

        Args:
            uri: the master's.
            python: ``ours`` for programs that import pyros1, or ``stock``.
            extra: more variables; None takes one away.
        """
        return child_environ(self.home, uri or None, python, {"ROS_HOSTNAME": None, **extra})

    def run(self, command: Sequence[str], environ: Mapping[str, str] | None = None, timeout: float = 60.0) -> Ended:
        """Run a program to its end, which must come within *timeout* seconds.

        Args:
            command: program and arguments.
            environ: the whole environment; without one that of a program of ours that knows no master.
        """
        done = subprocess.run(
            self.inside(command),
            env=dict(self.environ() if environ is None else environ),
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=timeout,
            check=False,
        )
        return Ended(done.returncode, (done.stdout + done.stderr).decode("utf-8", "replace"))

    def must(self, command: str, stdin: str | None = None) -> None:
        """Run a command of the system, such as ``ip route add ...``, that must succeed."""
        done = subprocess.run(
            self.inside(shlex.split(command)), input=stdin, capture_output=True, text=True, timeout=30, check=False
        )
        assert done.returncode == 0, f"{self.name}: {command}: {done.stderr}"

    def start(self, command: Sequence[str], environ: Mapping[str, str], label: str = "") -> Process:
        """Start a program that lives until the network ends at most."""
        process = Process(self.inside(command), environ, f"{label or Path(command[0]).name} on {self.name}")
        self.processes.append(process)
        return process

    def pyros1(self, *words: str) -> list[str]:
        """The command line of ``pyros1 WORDS``."""
        return [sys.executable, "-m", "pyros1", *words]

    def core(self, kind: str = "ours", port: int = 11311, *options: str, **extra: str | None) -> str:
        """Start a master and wait until it answers here; returns its URI, with the host's name.

        Args:
            kind: ``ours`` or ``stock``.
            port: TCP port.
            options: more arguments.
            extra: more environment variables.
        """
        uri = f"http://{self.name}:{port}/"
        command = self.pyros1("core", "-p", str(port)) if kind == "ours" else ["rosmaster", "--core", "-p", str(port)]
        self.start([*command, *options], self.environ(uri, kind, **extra), f"{kind} master")
        self.await_port(port)
        return uri

    def await_port(self, port: int) -> None:
        """Wait until somebody listens on a TCP port here."""
        probe = f"until ss -Hltn 'sport = :{port}' | grep -q .; do sleep 0.05; done"
        assert self.run(["timeout", "60", "sh", "-c", probe], timeout=70).code == 0, f"nobody listens on {port}"

    def peer(self, kind: str, name: str, uri: str, *arguments: str, **extra: str | None) -> Peer:
        """Start a peer program (see interop/README.md) and wait until its node is up.

        Args:
            kind: ``pyros1``, ``rospy`` or ``roscpp``.
            name: node name.
            uri: the master's.
            arguments: remappings.
            extra: more environment variables.
        """
        environ = self.environ(uri, "ours" if kind == "pyros1" else "stock", **extra)
        peer = Peer(self.inside([*peer_command(kind), name, *arguments]), environ, f"{kind} peer {name} on {self.name}")
        peer.kind = kind
        self.processes.append(peer)
        peer.name = peer.event("ready", timeout=60)
        return peer

    def forget(self, *names: str) -> None:
        """Take hosts out of this one's /etc/hosts: here their names have no address."""
        self.know(dict.fromkeys(names, ""))

    def know(self, addresses: Mapping[str, str]) -> None:
        """Write addresses of names into this host's /etc/hosts, in the place of those that are there.

        Args:
            addresses: one or several addresses by name, with blanks between them; empty for none.
        """
        path = self.home / "hosts"
        kept = [line for line in path.read_text().splitlines() if line.split()[1] not in addresses]
        added = [f"{one} {name}" for name, listed in addresses.items() for one in listed.split()]
        # The file is mounted in the host, so it must stay the same file.
        path.write_text("\n".join(kept + added) + "\n")

    def firewall(self, *rules: str) -> None:
        """Let in only what *rules* allow, in the place of earlier rules; the host itself may begin any connection.

        Others are refused at once, so that tests need not wait; end with a rule ``drop`` to be silent.

        Args:
            rules: of nft, such as ``tcp dport 11311 accept``.
        """
        chain = "type filter hook input priority 0; policy accept;"
        first = ("iif lo accept", "ct state established,related accept", "meta l4proto 58 accept")
        lines = "\n".join([chain, *first, *rules, "reject"])
        self.no_firewall()
        self.must("nft -f -", f"table inet filter {{\nchain input {{\n{lines}\n}}\n}}\n")

    def no_firewall(self) -> None:
        """Let everything in again."""
        self.must("nft -f -", "table inet filter\ndelete table inet filter\n")

    def close(self) -> None:
        """End everything that runs here, and the host."""
        for process in reversed(self.processes):
            process.close()
        assert self._keeper.stdin is not None and self._keeper.stdout is not None
        self._keeper.stdin.close()
        try:
            self._keeper.wait(DEADLINE)
        finally:
            self._keeper.kill()
            self._keeper.wait(DEADLINE)
            self._keeper.stdout.close()


def _propagation() -> str:
    """How mounts of a host stay its own: in the chroot of interop/bare_root they do, and / cannot be changed."""
    mounts = Path("/proc/self/mountinfo").read_text().splitlines()
    return "private" if any(line.split()[4] == "/" for line in mounts) else "unchanged"


class Network:
    """Hosts on one network, 10.88.0.0/24 and fd88::/64, joined by a switch; all know each other's names."""

    def __init__(self) -> None:
        missing = [name for name in ("ip", "nft", "nsenter", "unshare") if not shutil.which(name)]
        assert not missing, f"{', '.join(missing)} not found; run interop/setup"
        self._stack = contextlib.ExitStack()
        self._folder = Path(self._stack.enter_context(tempfile.TemporaryDirectory(prefix="pyros1-hosts-")))
        self._numbers = itertools.count(1)
        self.hosts: list[Host] = []
        self._ports: dict[Host, str] = {}
        try:
            self._switch = self._made(Host("switch", "10.88.0.254", "fd88::fe", self._folder))
            for command in ("link add name br0 type bridge", "addr add 10.88.0.254/24 dev br0", "link set br0 up"):
                self._switch.must(f"ip {command}")
        except BaseException:
            self._stack.close()
            raise

    def _made(self, host: Host) -> Host:
        self._stack.callback(host.close)
        return host

    def add(self, name: str, *, behind_nat: bool = False) -> Host:
        """Add a host.

        Args:
            name: its name.
            behind_nat: it is in a network of its own, 192.168.N.0/24, behind a router: it reaches the others, under the
                address of the router, and they cannot reach it (they are told so at once). No IPv6.
        """
        number = next(self._numbers)
        if behind_nat:
            address, gateway = f"192.168.{number}.1", f"192.168.{number}.254"
        else:
            address, gateway = f"10.88.0.{number}", "10.88.0.254"
        host = self._made(Host(name, address, "" if behind_nat else f"fd88::{number:x}", self._folder))
        port = self._ports[host] = f"port{number}"
        self._switch.must(f"ip link add name {port} type veth peer name eth0 netns {host.pid}")
        if behind_nat:
            self._switch.must(f"ip addr add {gateway}/24 dev {port}")
            self._translate(port, address)
        else:
            self._switch.must(f"ip link set {port} master br0")
            host.must(f"ip addr add {host.address6}/64 dev eth0 nodad")
        self._switch.must(f"ip link set {port} up")
        host.must(f"ip addr add {address}/24 dev eth0")
        host.must("ip link set eth0 up")
        host.must(f"ip route add default via {gateway}")
        self.hosts.append(host)
        for one in self.hosts:
            one.know({other.name: f"{other.address} {other.address6}" for other in self.hosts})
        return host

    def cut(self, host: Host) -> None:
        """Pull a host's plug: nothing comes in or goes out, and nobody is told."""
        self._switch.must(f"ip link set {self._ports[host]} down")

    def mend(self, host: Host) -> None:
        """Put its plug in again."""
        self._switch.must(f"ip link set {self._ports[host]} up")

    def _translate(self, port: str, address: str) -> None:
        """Let hosts behind a port of the switch out under its own address, and nobody in."""
        self._switch.must("sh -c 'echo 1 >/proc/sys/net/ipv4/ip_forward'")
        self._switch.must(
            "nft -f -",
            f"""table ip nat_{port} {{
              chain out {{ type nat hook postrouting priority 100; ip saddr {address} oifname br0 masquerade; }}
              chain forward {{ type filter hook forward priority 0; oifname {port} ct state new reject; }}
            }}""",
        )

    def close(self) -> None:
        """End all hosts."""
        self._stack.close()

    def __enter__(self) -> Network:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


@contextlib.contextmanager
def hosts(*names: str) -> Iterator[list[Host]]:
    """A network of hosts with these names."""
    with Network() as network:
        yield [network.add(name) for name in names]
