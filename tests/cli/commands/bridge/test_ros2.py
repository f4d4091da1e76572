"""bridge ros2: options, what is refused, and a running bridge."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from pyros1.cli.running import run_command
from pyros1.node import Node

pytest.importorskip("zenoh")
Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(environ: dict[str, str], monkeypatch: pytest.MonkeyPatch, call_main: Any) -> Run:
    for key, value in environ.items():
        monkeypatch.setenv(key, value)
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    return partial(call_main, partial(run_command, "bridge"), "ros2")


def test_check_explains(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    code, out, err = run("--check", "--send", "/odom", "--listen", "tcp/localhost:7447", "--domain", "5")
    assert (code, err) == (0, "") and out.splitlines()[:3] == [
        "ROS 2: domain 5, through tcp/localhost:7447 (as a router)",
        "from ROS 1 to ROS 2: /odom",
        "from ROS 2 to ROS 1: nothing",
    ]
    monkeypatch.setenv("ROS_DOMAIN_ID", "7")
    assert run("--check", "--via", "zenoh")[1].startswith("ROS 2: domain 7, through tcp/localhost:7447\n")


def test_which_nodes_are_reconfigured(run: Run) -> None:
    line = "parameters of ROS 2 nodes for dynamic_reconfigure: "
    assert f"{line}nothing" in run("--check", "--via", "zenoh")[1].splitlines()
    words = ("--reconfigure", "/camera", "/arm/**", "!/arm/tool", "--reconfigure", "/leg")
    assert (
        f"{line}/camera, /arm/**, /leg, but not /arm/tool" in run("--check", "--via", "zenoh", *words)[1].splitlines()
    )


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["--send", "odom"], "'odom' is not a pattern of"),
        (["--reconfigure", "camera"], "'camera' is not a pattern of"),
        (["--domain", "233"], "the domain must be a number from 0 to 232, not '233'"),
        (["--domain", "-1"], "the domain must be a number from 0 to 232, not '-1'"),
        (["--to", "tcp/robot:7447"], "is not encrypted"),
        (["--to", "robot"], "robot"),
        (["--to", "tls/localhost:7447", "--keys", "/nowhere"], "/nowhere"),
        (["--distribution", "jassy"], "the ROS 2 distribution 'jassy' are not known"),
        (["--via", "rclpy", "--listen", "tcp/localhost:7447"], "--listen has no meaning with --via rclpy"),
        (["--via", "rclpy", "--insecure"], "--insecure has no meaning with --via rclpy"),
        (["--via", "dds"], "dds"),
        (["--check", "--distribution", "jassy"], "the ROS 2 distribution 'jassy' are not known"),
    ],
)
def test_what_is_refused(run: Run, words: list[str], complaint: str) -> None:
    code, out, err = run(*words)
    assert code != 0 and complaint in err and not out and "Traceback" not in err


class Finding:
    """Which rclpy there is: None for none, or the folder with one."""

    def __init__(self, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        self.folder = folder
        self._monkeypatch = monkeypatch
        for name in [name for name in sys.modules if name.partition(".")[0] == "rclpy"]:
            monkeypatch.delitem(sys.modules, name)

    def write(self, node: str) -> None:
        """Let there be one with this code in its module ``node``."""
        package = self.folder / "rclpy"
        package.mkdir()
        (package / "__init__.py").write_text("")
        (package / "node.py").write_text(node)
        (package / "utilities.py").write_text("def get_rmw_implementation_identifier():\n    return 'rmw_of_tests'\n")
        self._monkeypatch.syspath_prepend(self.folder)


@pytest.fixture
def finding(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Finding]:
    yield Finding(tmp_path, monkeypatch)
    for name in [name for name in sys.modules if name.partition(".")[0] == "rclpy"]:
        del sys.modules[name]


def test_through_rclpy(run: Run, finding: Finding) -> None:
    finding.write("")
    (finding.folder / "share" / "lab_msgs" / "msg").mkdir(parents=True)
    (finding.folder / "share" / "lab_msgs" / "msg" / "Bench.msg").write_text("string data\n")
    for words in ([], ["--via", "rclpy"]):
        code, out, err = run("--check", *words)
        assert (code, err) == (0, "") and out.startswith("ROS 2: domain 0, through rclpy with rmw_of_tests\n")
        assert out.endswith("types of these packages, which this ROS 2 installation has: lab_msgs\n")
    code, out, _ = run("--check", "--ros2-packages", "/nowhere")
    assert code == 0 and "--ros2-packages is not used: through rclpy" in out
    assert "through tcp/localhost:7447 (as a router)\n" in run("--check", "--listen", "tcp/localhost:7447")[1]


@pytest.mark.slow
def test_pairs_through_rclpy(run: Run, finding: Finding) -> None:
    """What is not installed beside it is not exchanged, so it has no pair."""
    finding.write("")
    (finding.folder / "share" / "lab_msgs" / "msg").mkdir(parents=True)
    (finding.folder / "share" / "lab_msgs" / "msg" / "Bench.msg").write_text("string data\n")
    (finding.folder / "lab_msgs").mkdir()
    (finding.folder / "lab_msgs" / "__init__.py").write_text("")
    bench = "  lab_msgs/Bench <-> lab_msgs/msg/Bench: as it is defined in ROS 2\n"
    code, out, err = run("--pairs", "lab_msgs/msg/Bench", "std_msgs/String")
    assert (code, err) == (1, "") and out == (
        "messages, ROS 1 <-> ROS 2 beside rclpy:\n"
        f"  std_msgs/String: package std_msgs is not installed in this ROS 2 installation\n{bench}"
    )
    assert bench in run("--pairs")[1]
    assert "std_msgs/String <-> std_msgs/msg/String" in run("--pairs", "std_msgs/String", "--via", "zenoh")[1]


def test_without_rclpy(run: Run, finding: Finding, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.cli.commands.bridge._ros2_via.find_spec", lambda _: None)
    expected = "ROS 2: domain 0, through tcp/localhost:7447 (zenoh, since rclpy is not installed here)\n"
    assert run("--check")[1].startswith(expected)
    code, _, err = run("--check", "--via", "rclpy")
    assert code != 0 and "rclpy is not installed here; run `source" in err


def test_an_rclpy_of_another_python(run: Run, finding: Finding) -> None:
    finding.write("raise ImportError('no C library')\n")
    assert "(zenoh, since rclpy cannot be imported: no C library)\n" in run("--check")[1]
    code, _, err = run("--via", "rclpy")
    assert code != 0 and "rclpy cannot be imported: no C library" in err and "Traceback" not in err


def test_mapping_files(run: Run, tmp_path: Path) -> None:
    (tmp_path / "flat_msgs/msg").mkdir(parents=True)
    (tmp_path / "flat_msgs/msg/Flat.msg").write_text("float64 east\nfloat64 north\n")
    rule = "- {ros1_package_name: geometry_msgs, ros1_message_name: Point,"
    rule += " ros2_package_name: flat_msgs, ros2_message_name: Flat, fields_1_to_2: {x: east, y: north}}\n"
    path = tmp_path / "map.yaml"
    path.write_text(rule)
    words = ["--check", "--mapping", str(path), "--ros2-packages", str(tmp_path)]
    code, out, err = run(*words)
    assert (code, err) == (0, "") and out.splitlines()[-2:] == [
        f"{path}:1: geometry_msgs/Point is flat_msgs/msg/Flat",
        "    geometry_msgs/Point is flat_msgs/msg/Flat, but only ROS 1 has z: left out on the way there, zero or "
        "empty on the way back",
    ]
    path.write_text(rule + rule)
    code, out, err = run(*words)
    assert (code, out) == (2, "") and f"{path}:2: there is already a rule" in err
    for word in ("--mapping", "--ros2-packages"):
        code, out, err = run("--check", word, str(tmp_path / "missing"))
        assert (code, out) == (2, "") and "missing" in err and "Traceback" not in err


def test_parameters_of_ros1_bridge(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "bridge.yaml"
    path.write_text("topics:\n- {topic: /chatter, type: std_msgs/msg/String, qos: {depth: 3}}\n")
    code, out, err = run("--check", "--parameters", str(path), "--take", "/scan")
    assert (code, err) == (0, "") and out.splitlines()[1:3] == [
        "from ROS 1 to ROS 2: /chatter",
        "from ROS 2 to ROS 1: /scan, /chatter",
    ]
    assert f"{path}:2: qos is not used" in out.splitlines()[-1]
    path.write_text("topics: 3\n")
    code, out, err = run("--check", "--parameters", str(path))
    assert (code, out) == (2, "") and f"{path}:1: expected a mapping" in err


def test_pairs_of_types(run: Run) -> None:
    assert run("--pairs", "std_msgs/String", "std_srvs/srv/SetBool") == (
        0,
        "messages, ROS 1 <-> ROS 2 jazzy:\n  std_msgs/String <-> std_msgs/msg/String\n"
        "services, ROS 1 <-> ROS 2 jazzy:\n  std_srvs/SetBool <-> std_srvs/srv/SetBool\n",
        "",
    )
    code, out, err = run("--pairs", "nowhere/Nothing", "--distribution", "humble")
    assert (code, out, err) == (1, "", "nowhere/Nothing: neither ROS 1 nor ROS 2 has such a type here\n")
    code, out, err = run("--pairs", "std_msgs/Strng")
    assert (code, out) == (1, "") and "(did you mean 'std_msgs/String'?)" in err
    assert "'jassy' are not known" in run("--pairs", "--distribution", "jassy")[2]


def test_a_domain_that_is_no_number(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "lab")
    assert "ROS_DOMAIN_ID must be a number from 0 to 232, not 'lab'" in run("--check")[2]


def test_without_a_master(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_MASTER_URI", "http://localhost:9/")
    code, _, err = run()
    assert code != 0 and "Unable to communicate with master" in err


def test_a_port_that_is_in_use(run: Run) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        endpoint = f"tcp/127.0.0.1:{server.getsockname()[1]}"
        code, out, err = run("--listen", endpoint)
    assert code != 0 and not out and f"cannot listen on {endpoint}: another program does" in err


@pytest.mark.slow
def test_a_running_bridge(make_node: Callable[..., Node], environ: dict[str, str]) -> None:
    command = [sys.executable, "-m", "pyros1", "bridge", "ros2", "--listen", "tcp/127.0.0.1:0"]
    with subprocess.Popen(command, env={**os.environ, **environ}, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        try:
            line = process.stderr.readline()
            assert line.startswith("bridge to ROS 2, domain 0, through tcp/127.0.0.1:0 (as a router)"), line
        finally:
            process.send_signal(signal.SIGINT)
        assert process.wait(20) in (0, 130, -signal.SIGINT) and "Traceback" not in process.stderr.read()
