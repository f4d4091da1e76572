"""Texts that stock's tools ran as Python, given to ours: nothing runs, and one line says what is wrong.

Feature: the published vulnerabilities of ROS 1 are not present -- each is attacked:
    [interop/security.md](interop/security.md)
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterator
from html import escape
from pathlib import Path
from typing import Any

import pytest

from pyros1.bag import Bag
from pyros1.cli.main import entry
from pyros1.ground.errors import Error, LaunchError
from pyros1.launch.reading.loader import load_plan
from pyros1.launch.reading.system_resources import make_resources
from pyros1.launch.running.logs import make_run_folder
from pyros1.msgs import load_message
from pyros1.node.log.sink import default_log_file
from pyros1.reconfigure import Parameters, Server

from ..bag.made import write_bag
from .hostile import assert_clean

EXPRESSIONS = [
    "__import__('os').system('touch {}')",
    "open('{}', 'w')",
    'eval(\'open("{}", "w")\')',
    "().__class__.__base__.__subclasses__()",
    "m.__class__.__init__.__globals__",
    "(lambda: open('{}', 'w'))()",
    "[open(x, 'w') for x in ['{}']]",
    "m.data.__class__",
]
ONLY_WITH_A_MESSAGE = ["getattr(m, '__cla' + 'ss__')", "'{{0.__class__}}'.format(m)"]
"""These are found when they are evaluated."""
"""For filters, substitutions and angles; ``{}`` is the file that they would make."""
YAML = [
    "!!python/object/apply:os.system ['touch {}']",
    "!!python/object/new:os.system ['touch {}']",
    "!!python/name:os.system",
    "!!python/object/apply:builtins.open ['{}', 'w']",
    "!radians __import__('os').system('touch {}')",
    "!degrees __import__('os').system('touch {}')",
]


@pytest.fixture
def made(tmp_path: Path) -> Iterator[Path]:
    """The file that an attack would make; none has made it in the end."""
    path = tmp_path / "made"
    yield path
    assert not path.exists(), "a text was run"


@pytest.fixture
def run(
    made: Path, monkeypatch: pytest.MonkeyPatch, call_main: Any, environ: dict[str, str]
) -> Callable[..., tuple[int, str, str]]:
    """Return a function that runs a command; ``{}`` in its words is the file that must not be made."""
    monkeypatch.chdir(made.parent)
    for name, value in environ.items():
        monkeypatch.setenv(name, value)

    def run(*words: str) -> tuple[int, str, str]:
        code, out, err = call_main(entry, "pyros1", *words)
        assert "Traceback" not in out + err, words
        assert_clean(err, words)
        return code, out, err

    return run


@pytest.mark.parametrize("text", EXPRESSIONS + ONLY_WITH_A_MESSAGE)
def test_filters(run: Any, made: Path, make_node: Any, text: str) -> None:
    """CVE-2024-41148, CVE-2024-41921, CVE-2025-3753."""
    expression = text.format(made)
    bag = write_bag(made.parent / "in.bag", count=4)
    code, out, err = run("topic", "echo", "-b", str(bag), "--filter", expression, "/a")
    assert err and not out
    code, _, err = run("bag", "filter", str(bag), "out.bag", expression)
    assert code and err
    if text not in ONLY_WITH_A_MESSAGE:
        code, _, err = run("topic", "hz", "--filter", expression, "/none")
        assert code and err


@pytest.mark.parametrize("text", EXPRESSIONS)
def test_substitutions_of_launch_files(run: Any, made: Path, text: str) -> None:
    """CVE-2024-39835."""
    expression = text.format(made).replace('"', "&quot;").replace("<", "&lt;")
    for inside in (
        '<param name="p" value="$(eval {})"/>',
        '<group if="$(eval {})"/>',
        '<arg name="m" value="$(eval {})"/>',
    ):
        (made.parent / "x.launch").write_text(f"<launch>{inside.replace('{}', expression)}</launch>")
        _, out, err = run("launch", "--dump-params", "x.launch")
        assert "x.launch:1" in err and not out


@pytest.mark.parametrize("text", YAML)
def test_values(run: Any, made: Path, make_node: Any, text: str) -> None:
    """CVE-2020-10289, CVE-2024-39289."""
    value = text.format(made)
    (made.parent / "x.yaml").write_text(f"a: {value}\n")
    (made.parent / "x.launch").write_text(f"<launch><rosparam>a: {value.replace('<', '&lt;')}</rosparam></launch>")
    received: list[Any] = []
    node = make_node("victim")
    node.subscribe("/t", load_message("std_msgs/String"), received.append)
    node.advertise_service("/s", "std_srvs/SetBool", received.append)
    for words in (
        ("param", "set", "/p", value),
        ("param", "load", "x.yaml"),
        ("launch", "--dump-params", "x.launch"),
        ("topic", "pub", "-1", "/t", "std_msgs/String", f"data: {value}"),
        ("service", "call", "/s", f"data: {value}"),
        ("action", "send", "/none", "-t", "actionlib_tutorials/Fibonacci", f"order: {value}"),
    ):
        code, _, _ = run(*words)
        assert code or words[0] in ("param", "launch"), words
    assert not received and "/p" not in node.params and "/a" not in node.params


@pytest.mark.parametrize("text", YAML)
def test_values_of_dynamic_reconfigure(run: Any, made: Path, make_node: Any, text: str) -> None:
    """CVE-2024-39780."""
    parameters = Parameters()
    parameters.add("gain", 0.5)
    changes: list[float] = []
    server = Server(make_node("camera"), parameters, lambda config, level: changes.append(config.gain) or config)
    value = text.format(made)
    (made.parent / "x.yaml").write_text(f"gain: {value}\n")
    for words in (
        ("dynparam", "set", "/camera", "gain", value),
        ("dynparam", "set", "/camera", f"{{gain: {value}}}"),
        ("dynparam", "load", "/camera", "x.yaml"),
    ):
        code, out, err = run(*words)
        assert code and out + err, words
    assert changes == [0.5], server


def test_words_of_launch_files_reach_no_shell(run: Any, made: Path) -> None:
    words = f"; touch {made} ; $(touch {made}) `touch {made}` && touch {made} | touch {made} > {made}"
    escaped = words.replace("&", "&amp;").replace("$(", "$[").replace(">", "&gt;")
    (made.parent / "x.launch").write_text(
        "<launch>"
        f'<param name="p" command="echo {escaped}"/>'
        f'<node pkg="pyros1" type="none; touch {made}" name="n" args="{escaped}"/></launch>'
    )
    code, out, _ = run("launch", "--dump-params", "x.launch")
    assert code == 0 and "touch" in out
    assert run("launch", "--nodes", "x.launch")[0] == 0


@pytest.mark.parametrize("option", [("--size", "9" * 30), ("--split=" + "9" * 30,), ("--size", str(2**63))])
def test_sizes_of_any_length(run: Any, made: Path, make_node: Any, option: tuple[str, ...]) -> None:
    """CVE-2019-13445."""
    string: Any = load_message("std_msgs/String")
    make_node("talker").advertise("/t", string, latch=True).publish("x")
    code, _, err = run("bag", "record", "--split", *option, "--limit", "1", "-O", "x", "/t")
    assert code == 0, err
    (path,) = made.parent.glob("x*.bag")
    with Bag(path) as bag:
        assert len(bag) == 1


@pytest.mark.parametrize(
    "name", ["../../x", "..", "/../x", "a/../../x", "x\0y", "x\ny", "/etc/cron.d/x", "~/x", "$(x)", "x;y"]
)
def test_names_are_no_paths(made: Path, make_node: Any, environ: dict[str, str], name: str) -> None:
    """A node's name names its log file, wherever it comes from."""
    folder = made.parent / "ros" / "log"
    file = Path(default_log_file(name, environ, {}))
    assert Path(os.path.abspath(file)).parent == folder
    (made.parent / "x.launch").write_text(f'<launch><node pkg="p" type="t" name="{escape(name)}"/></launch>')
    if name != "/etc/cron.d/x":
        with pytest.raises(Error):
            make_node(name)
        with contextlib.suppress(LaunchError):
            plan = load_plan([str(made.parent / "x.launch")], {}, make_resources())
            assert not any("/" in node.name or "\0" in node.name for node in plan.nodes)


@pytest.mark.parametrize("run_id", ["../../../made", "/tmp/pyros1_made", "..", ".", ".ssh", ""])
def test_the_run_id_of_a_master_is_no_path(made: Path, environ: dict[str, str], run_id: str) -> None:
    """Programs that launch nodes put their logs into a folder of that name."""
    before = sorted(made.parent.rglob("*"))
    with pytest.raises(LaunchError, match="not a valid run id"):
        make_run_folder(environ, run_id)
    assert sorted(made.parent.rglob("*")) == before and not Path("/tmp/pyros1_made").exists()
