"""Cables whose faults a test chooses: every packet between hosts passes through this process.

    with hosts("robot", "laptop") as (robot, laptop), Wires(robot, laptop) as wires:
        wires.path(robot, laptop).open = False      # what the robot sends is lost, and nobody is told

The kernel can lose and delay packets itself (`tc netem`), but many kernels are built without that.
"""

from __future__ import annotations

import ctypes
import fcntl
import heapq
import itertools
import os
import random
import select
import socket
import stat
import struct
import tempfile
import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from time import monotonic
from types import TracebackType

from hosts import Host

_TUNSETIFF = 0x400454CA
_TUN = 0x0001 | 0x1000  # IFF_TUN | IFF_NO_PI: packets as they are
_CLONE_NEWNET = 0x40000000
_MOST = 65536


@dataclass
class OneWay:
    """What happens to the packets from one host to another.

    Attributes:
        open: whether any arrive.
        lost: share of packets that are lost, 0 to 1.
        delay: seconds that a packet takes.
        jitter: most seconds more, at random for each packet, so that packets overtake each other.
        rate: bytes per second; None: no limit.
        room: bytes that may wait where there is a rate; packets beyond that are lost.
        passes: called with each packet; False loses it. None: all pass.
        carried: packets that have passed.
    """

    open: bool = True
    lost: float = 0.0
    delay: float = 0.0
    jitter: float = 0.0
    rate: float | None = None
    room: int = 10_000
    passes: Callable[[bytes], bool] | None = None
    carried: int = 0
    _free_at: float = field(default=0.0, repr=False)

    def arrival(self, packet: bytes, dice: random.Random) -> float | None:
        """The time at which a packet arrives; None: never."""
        if not self.open or dice.random() < self.lost or (self.passes is not None and not self.passes(packet)):
            return None
        at = monotonic()
        if self.rate is not None:
            begin = max(at, self._free_at)
            if (begin - at) * self.rate > self.room:
                return None
            at = self._free_at = begin + len(packet) / self.rate
        self.carried += 1
        return at + self.delay + dice.random() * self.jitter


class Wires:
    """Cables between hosts, in the place of their usual one.

    Args:
        hosts: all hosts that are to reach each other.
    """

    def __init__(self, *hosts: Host) -> None:
        self._hosts = hosts
        self._paths = {(one, other): OneWay() for one in hosts for other in hosts if one is not other}
        self._ends = {_plug_in(host): host for host in hosts}
        self._closing = False
        self._thread = threading.Thread(target=self._carry, name="wires")
        self._thread.start()

    def path(self, sender: Host, receiver: Host) -> OneWay:
        """The way of packets from one host to another."""
        return self._paths[sender, receiver]

    def both_ways(self, one: Host, other: Host) -> tuple[OneWay, OneWay]:
        """The ways of packets between two hosts."""
        return self._paths[one, other], self._paths[other, one]

    def cut(self, *hosts: Host) -> None:
        """Let the hosts vanish: nothing comes in or goes out, and nobody is told."""
        self._set_open(hosts, False)

    def mend(self, *hosts: Host) -> None:
        """Undo `cut`."""
        self._set_open(hosts, True)

    def _set_open(self, hosts: tuple[Host, ...], is_open: bool) -> None:
        for (one, other), path in self._paths.items():
            if one in hosts or other in hosts:
                path.open = is_open

    def _carry(self) -> None:
        ends = {host: end for end, host in self._ends.items()}
        by_address = {
            socket.inet_pton(family, address): host
            for host in self._hosts
            for family, address in ((socket.AF_INET, host.address), (socket.AF_INET6, host.address6))
        }
        under_way: list[tuple[float, int, int, bytes]] = []
        numbers, dice = itertools.count(), random.Random(1)
        while not self._closing:
            wait = min(0.05, max(0.0, under_way[0][0] - monotonic())) if under_way else 0.05
            for end in select.select(list(self._ends), [], [], wait)[0]:
                packet = os.read(end, _MOST)
                to = by_address.get(packet[16:20] if packet[0] >> 4 == 4 else packet[24:40])
                if to is None or to is self._ends[end]:
                    continue
                at = self._paths[self._ends[end], to].arrival(packet, dice)
                if at is not None:
                    heapq.heappush(under_way, (at, next(numbers), ends[to], packet))
            while under_way and under_way[0][0] <= monotonic():
                _, _, end, packet = heapq.heappop(under_way)
                os.write(end, packet)

    def close(self) -> None:
        """Remove the cables."""
        self._closing = True
        self._thread.join()
        for end in self._ends:
            os.close(end)

    def __enter__(self) -> Wires:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def _plug_in(host: Host) -> int:
    """Replace a host's cable, and return the descriptor of the other end of the new one."""
    made: list[int] = []

    def enter() -> None:
        with open(f"/proc/{host.pid}/ns/net") as namespace:
            if ctypes.CDLL(None, use_errno=True).setns(namespace.fileno(), _CLONE_NEWNET):
                raise OSError(ctypes.get_errno(), f"cannot enter {host.name}")
        end = _open_tun()
        fcntl.ioctl(end, _TUNSETIFF, struct.pack("16sH22x", b"eth0", _TUN))
        made.append(end)

    host.must("ip link del eth0")
    thread = threading.Thread(target=enter)  # of its own, since it stays in that namespace
    thread.start()
    thread.join()
    assert made, f"no cable for {host.name}"
    for words in ("addr add {0.address}/24", "addr add {0.address6}/64 nodad", "link set up"):
        host.must(f"ip {words.format(host)} dev eth0")
    host.must("ip route add default dev eth0")
    return made[0]


def _open_tun() -> int:
    flags = os.O_RDWR | os.O_CLOEXEC
    if os.path.exists("/dev/net/tun"):
        return os.open("/dev/net/tun", flags)
    with tempfile.TemporaryDirectory() as folder:  # a chroot has few devices
        path = Path(folder) / "tun"
        os.mknod(path, stat.S_IFCHR | 0o600, os.makedev(10, 200))
        return os.open(path, flags)
