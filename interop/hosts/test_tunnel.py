"""The guide's recipes for networks that are not trusted: only ssh or WireGuard is let in, and ROS goes through it.

Feature: all of ROS through ssh -- `ssh -w` both ways, `ssh -L` one way
"""

from __future__ import annotations

import os
from pathlib import Path

from harness import until
from hosts import Host, Network
from sshd import prepare

URI = "http://10.99.0.1:11311/"
STRING = "std_msgs/String"


def ssh(folder: Path, *words: str) -> list[str]:
    return ["ssh", "-F", str(folder / ".ssh" / "config"), "-o", f"UserKnownHostsFile={folder}/.ssh/known_hosts", *words]


def make_device() -> None:
    """The device of tunnels; a chroot may not have it."""
    device = Path("/dev/net/tun")
    if not device.exists():
        device.parent.mkdir(exist_ok=True)
        os.mknod(device, 0o20600, os.makedev(10, 200))


def has_tunnel(host: Host, device: str = "tun0") -> bool:
    return host.run(["ip", "link", "show", device]).code == 0


def test_all_of_ros_through_ssh_w(tmp_path: Path) -> None:
    """Both ways: each machine gets an address in the tunnel, and everything listens at that alone."""
    make_device()
    with Network() as network:
        robot, laptop = network.add("robot"), network.add("laptop")
        server = prepare(tmp_path, robot.address, 22, "PermitTunnel yes\n")
        robot.start(server, robot.environ(), "sshd")
        robot.await_port(22)
        robot.firewall("tcp dport 22 accept", "iifname tun0 accept")
        laptop.start(ssh(tmp_path, "-N", "-w", "0:0", "robot"), laptop.environ(), "ssh")
        for host, own, other in ((robot, "10.99.0.1", "10.99.0.2"), (laptop, "10.99.0.2", "10.99.0.1")):
            until(lambda host=host: has_tunnel(host), "the tunnel is there", timeout=40)
            host.must(f"ip addr add {own} peer {other} dev tun0")
            host.must("ip link set tun0 up")
        talk_through(robot, laptop)


def talk_through(robot: Host, laptop: Host) -> None:
    """Messages go both ways through the tunnel, and nothing beside it."""
    robot.start(robot.pyros1("core"), robot.environ(URI, PYROS1_BIND="10.99.0.1"), "core")
    robot.await_port(11311)
    talker = robot.peer("pyros1", "talker", URI, PYROS1_BIND="10.99.0.1")
    listener = laptop.peer("roscpp", "listener", URI, ROS_IP="10.99.0.2")
    for one, other in ((talker, listener), (listener, talker)):
        topic = f"/from{one.name}"
        other.subscribe(topic, STRING)
        one.advertise(topic, STRING, latch=True)
        one.publish(topic)
        other.received(topic, timeout=40)
    outside = laptop.run(["rostopic", "list"], laptop.environ("http://robot:11311", "stock"))
    assert outside.code == 1 and "Unable to communicate with master" in outside.output


def test_all_of_ros_through_wireguard(tmp_path: Path) -> None:
    """Both ways, with keys. The device is made by wireguard-go, as not every kernel has WireGuard."""
    make_device()
    with Network() as network:
        robot, laptop = network.add("robot"), network.add("laptop")
        for host in (robot, laptop):
            key, public = tmp_path / host.name, tmp_path / f"{host.name}.pub"
            host.must(f"sh -c 'umask 077; wg genkey > {key} && wg pubkey < {key} > {public}'")
            # In the foreground it ends with the host; its socket's folder must not be another host's.
            mount = "mkdir -p /var/run/wireguard && mount -t tmpfs tmpfs /var/run/wireguard"
            host.must(f"sh -c '{mount}'")
            host.start(["wireguard-go", "-f", "wg0"], {**host.environ(), "LOG_LEVEL": "error"}, "wireguard-go")
            until(lambda host=host: has_tunnel(host, "wg0"), "the tunnel is there", timeout=40)
        robot.must("ip addr add 10.99.0.1/24 dev wg0")
        laptop.must("ip addr add 10.99.0.2/24 dev wg0")
        keys = {host.name: (tmp_path / f"{host.name}.pub").read_text().strip() for host in (robot, laptop)}
        robot.must(
            f"wg set wg0 listen-port 51820 private-key {tmp_path}/robot peer {keys['laptop']} allowed-ips 10.99.0.2/32"
        )
        laptop.must(
            f"wg set wg0 private-key {tmp_path}/laptop peer {keys['robot']} endpoint {robot.address}:51820 "
            "allowed-ips 10.99.0.1/32"
        )
        for host in (robot, laptop):
            host.must("ip link set wg0 up")
        robot.firewall("udp dport 51820 accept", "iifname wg0 accept")
        talk_through(robot, laptop)


def test_one_way_through_ssh_l(tmp_path: Path) -> None:
    """Without root: ports of a range are forwarded, and the robot's name means this machine."""
    with Network() as network:
        robot, laptop = network.add("robot"), network.add("laptop")
        server = prepare(tmp_path, robot.address, 22)
        robot.start(server, robot.environ(), "sshd")
        robot.await_port(22)
        robot.firewall("tcp dport 22 accept")
        uri = robot.core("ours", 11311, "--ports", "40000-40005")
        talker = robot.peer("pyros1", "talker", uri, PYROS1_PORTS="40000-40005")
        talker.advertise("/t", STRING, latch=True)
        talker.serve("/s", "std_srvs/SetBool")
        talker.publish("/t")
        forwards = [word for port in (11311, *range(40000, 40006)) for word in ("-L", f"{port}:robot:{port}")]
        laptop.start(ssh(tmp_path, "-N", *forwards, "robot"), laptop.environ(), "ssh")
        laptop.await_port(11311)
        laptop.know({"robot": "127.0.0.1"})
        for kind in ("roscpp", "pyros1"):
            listener = laptop.peer(kind, f"listener_{kind}", uri)
            listener.subscribe("/t", STRING)
            listener.received("/t", timeout=40)
            listener.call("/s", "std_srvs/SetBool")
