"""`pyros1 web`: its words, its messages, and how a second one finds the first."""

from __future__ import annotations

import base64
import contextlib
import json
import os
import re
import signal
import socket
import stat
import subprocess
import sys
import threading
import time
import urllib.request
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from websockets.sync.client import connect

import pyros1
from pyros1.bag import BagWriter
from pyros1.cli.registry import stock_names
from pyros1.graph import Graph
from pyros1.master.server import Master
from pyros1.net.master_client import MasterClient

pytestmark = pytest.mark.once

Start = Callable[..., "subprocess.Popen[str]"]
PACKAGES = Path(pyros1.__file__).parent / "packages"


@pytest.fixture
def start(environ: dict[str, str]) -> Iterator[Start]:
    """Return a function that starts ``pyros1 web`` with some words; its browser does nothing."""
    processes: list[subprocess.Popen[str]] = []

    def begin(*words: str, **more: str) -> subprocess.Popen[str]:
        processes.append(
            subprocess.Popen(
                [sys.executable, "-m", "pyros1", "web", *words],
                env={**os.environ, **environ, "BROWSER": "true", **more},
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
            )
        )
        return processes[-1]

    yield begin
    for process in processes:
        process.terminate()
        assert "Traceback" not in process.communicate(timeout=30)[0]


def first_line(process: subprocess.Popen[str]) -> str:
    assert process.stdout is not None
    return process.stdout.readline()


def link_in(line: str) -> str:
    match = re.search(r"http://localhost:\d+/\S*$", line.strip().removesuffix("\n"))
    assert match, line
    return match[0]


def settings_in(link: str) -> object:
    text = link.partition("#")[2].partition("=")[2]
    return json.loads(base64.urlsafe_b64decode(text + "=" * (-len(text) % 4)))


@pytest.mark.slow
def test_it_prints_a_link_that_works_and_ends_with_a_signal(start: Start) -> None:
    process = start("--port", "0")
    link = link_in(first_line(process))
    assert re.search(r"\?token=[\w-]{20,}$", link)
    with urllib.request.urlopen(link, timeout=20) as answer:
        assert b"<title>pyros1</title>" in answer.read()
    process.send_signal(signal.SIGINT)
    assert process.wait(20) == 0


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="other systems always have a display")
def test_without_a_display_no_browser_is_opened(start: Start, tmp_path: Path) -> None:
    """Python would take a browser for terminals, such as w3m."""
    browser = tmp_path / "w3m"
    browser.write_text(f"#!/bin/sh\ntouch {tmp_path}/opened\n")
    browser.chmod(0o755)
    path = f"{tmp_path}{os.pathsep}{os.environ['PATH']}"
    process = start("--port", "0", "--open", BROWSER="", DISPLAY="", WAYLAND_DISPLAY="", PATH=path)
    link = link_in(first_line(process))
    assert first_line(process) == f"no browser could be opened here; open the link yourself: {link}\n"
    assert not (tmp_path / "opened").exists()


@pytest.mark.slow
def test_a_panel_of_a_server_that_runs(start: Start, environ: dict[str, str]) -> None:
    server = start("--port", "0")
    link = link_in(first_line(server))
    (note,) = Path(environ["ROS_HOME"], "pyros1").iterdir()
    assert stat.S_IMODE(note.stat().st_mode) == 0o600  # it has the token
    for words, settings in [
        (["plot", "/velocity/data,force"], {"curves": ["/velocity/data", "/force"]}),
        (["plot", "b: hypot(m.x, m.y)"], {"curves": ["/b: hypot(m.x, m.y)"]}),
        (["plot", "--xy", "/a/x:y"], {"curves": ["/a/x", "/a/y"], "xy": True}),
        (["plot", "-p", "5", "-P", "/a/x:y"], {"curves": ["/a/x", "/a/y"], "period": 5.0, "paused": True}),
    ]:
        other = start(*words)
        found = link_in(first_line(other))
        assert other.wait(20) == 0
        assert found.startswith(f"{link}#plot=")
        assert settings_in(found) == {"panel": "plot", "settings": settings}
    found = link_in(first_line(start("image", "camera/image")))
    assert found.startswith(f"{link}#image=")
    for panel, word, setting in (
        ("nodes", "arm", "selected"),
        ("topics", "/a", "selected"),
        ("launches", "arm", "node"),
    ):
        shown = link_in(first_line(start(panel, word))).partition(f"#{panel}=")[2]
        settings = json.loads(base64.urlsafe_b64decode(shown + "=" * (-len(shown) % 4)))["settings"]
        assert settings == {setting: "/" + word.lstrip("/")}
    for words, panel, settings in (
        (["reconfigure"], "params", {"reconfigure": ""}),
        (["reconfigure", "arm"], "params", {"reconfigure": "/arm"}),
        (["publisher"], "topics", {"publish": ""}),
        (["publisher", "vel_cmd"], "topics", {"publish": "/vel_cmd"}),
        (["--open", "-s", "rqt_plot/Plot", "/a/x"], "plot", {"curves": ["/a/x"]}),  # rqt -s rqt_plot/Plot
        (["scene", "-f", "odom"], "scene", {"fixed": "odom"}),  # rviz -f odom
        (["scene", "--target-frame", "/base"], "scene", {"target": "base"}),
        (["plot", "--empty"], "plot", {"curves": []}),  # rqt_plot -e
    ):
        assert settings_in(link_in(first_line(start(*words)))) == {"panel": panel, "settings": settings}
    other = start("console")
    assert link_in(first_line(other)) == f"{link}#console"
    server.terminate()
    assert server.wait(20) == 0
    assert not note.exists()


@pytest.mark.slow
def test_a_bag_of_any_folder_is_opened_by_a_server_that_runs(
    start: Start, environ: dict[str, str], tmp_path: Path
) -> None:
    bag, other = tmp_path / "a.bag", tmp_path / "b.bag"
    for path in (bag, other):
        BagWriter(path).close()
    (tmp_path / "empty").mkdir()
    link = link_in(first_line(start("--port", "0", "--bags", str(tmp_path / "empty"))))
    opened = start("rqt_bag", str(bag))
    assert settings_in(link_in(first_line(opened))) == {"panel": "bag", "settings": {"files": [str(bag)]}}
    assert opened.wait(20) == 0
    for file in Path(environ["ROS_HOME"], "pyros1").iterdir():
        assert stat.S_IMODE(file.stat().st_mode) == 0o600
    with connect(link.replace("http", "ws", 1).replace("/?", "/ws?"), open_timeout=20) as page:
        said = []
        for number, path in enumerate((bag, other)):
            page.send(json.dumps({"open": "bag_file", "stream": number, "args": {"path": str(path)}}))
            said.append(str(page.recv(timeout=20)))
    assert "outside" not in said[0] and "outside the folders" in said[1]
    (lists,) = Path(environ["ROS_HOME"], "pyros1").glob("*.bags")
    lists.chmod(0o644)
    refused = start("rqt_bag", str(other))
    assert f"{lists}: the list of bags can be read" in refused.communicate(timeout=30)[0] and refused.returncode == 1
    misspelt = start("bag", str(tmp_path / "aa.bag"))
    assert f"(did you mean '{bag}'?)" in misspelt.communicate(timeout=30)[0] and misspelt.returncode == 1


@pytest.mark.slow
def test_a_note_of_a_server_that_is_gone_does_no_harm(start: Start, environ: dict[str, str]) -> None:
    server = start("--port", "0")
    first_line(server)
    server.kill()
    server.wait(20)
    other = start("--port", "0", "plot")
    link = link_in(first_line(other))
    assert link.endswith("#plot")
    with urllib.request.urlopen(link, timeout=20) as answer:
        assert answer.status == 200


@pytest.mark.slow
def test_a_file_of_rviz(start: Start, tmp_path: Path) -> None:
    file = tmp_path / "robot.rviz"
    displays = "[{Class: rviz/Path, Topic: plan, Color: 0; 0; 255}, {Class: my/Thing, Name: Thing}]"
    file.write_text(f"Visualization Manager: {{Displays: {displays}, Global Options: {{Fixed Frame: map}}}}")
    link_in(first_line(start("--port", "0")))
    for words in (["rviz", "-d", str(file)], ["rviz", str(file)], ["scene", f"--display-config={file}"]):
        process = start(*words, "-f", "odom")
        assert first_line(process) == f"{file}: Thing: unsupported display my/Thing\n"
        assert settings_in(link_in(first_line(process))) == {
            "panel": "scene",
            "settings": {
                "fixed": "odom",
                "topics": ["/plan"],
                "robots": [],
                "options": {"/plan": {"tint": "#0000ff"}},
                "hidden": ["frames", "grid"],
            },
        }
    file.write_text("Visualization Manager: [")
    faults = {file: f"ERROR: {file} is not YAML: ", tmp_path: "Is a directory", tmp_path / "no.rviz": "No such file"}
    for name, said in faults.items():
        process = start("rviz", "-d", str(name))
        output, _ = process.communicate(timeout=30)
        assert process.returncode == 1
        assert said in output and str(name) in output and output.count("\n") == 1


@pytest.mark.slow
def test_rviz_alone_shows_its_usual_file(start: Start, tmp_path: Path) -> None:
    file = tmp_path / ".rviz" / "default.rviz"
    file.parent.mkdir()
    file.write_text("Visualization Manager: {Global Options: {Fixed Frame: odom}}")
    link_in(first_line(start("--port", "0")))
    fixed = []
    for word in ("rviz", "scene"):  # the latter is ours, and has what was shown last
        link = link_in(first_line(start(word, HOME=str(tmp_path))))
        fixed.append(link.endswith("#scene") or settings_in(link)["settings"]["fixed"])
    assert fixed == ["odom", True]
    file.write_text("Visualization Manager: [")
    process = start("rviz", HOME=str(tmp_path))
    assert first_line(process).startswith(f"{file} is not YAML: ")
    assert link_in(first_line(process)).endswith("#scene")  # it opens all the same


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["nothing"], "there is no panel 'nothing'; the panels are "),
        (["console", "/x"], "the panel console takes no arguments"),
        (["nodes", "/x", "/y"], "the panel nodes takes one node"),
        (["--layout", "Tutorial", "plot"], "--layout opens a whole layout: do not name a panel as well"),
        (["-s", "rqt_shell"], "there is no plugin 'rqt_shell'; the plugins are rqt_bag, "),
        (["--port", "70000"], "the port must be from 0 to 65535"),
        (["bag", "/nowhere/at/all.bag"], "ERROR: there is no file /nowhere/at/all.bag\n"),
        (["bag", "/etc/passwd"], "ERROR: /etc/passwd: this is not a bag file\n"),
        (["-s", "rqt_bag", "/dev/null"], "ERROR: /dev/null: the file is empty: nothing was recorded\n"),
        (["rqt_bag", "/usr"], "ERROR: /usr is a folder, not a bag; --bags /usr shows its bags\n"),
        (["--max-pages", "0"], "--max-pages must be from 1 to 10000"),
    ],
)
def test_wrong_words(start: Start, words: list[str], said: str) -> None:
    process = start(*words)
    output, _ = process.communicate(timeout=30)
    assert process.returncode != 0
    assert said in output


@pytest.mark.slow
def test_a_port_that_is_taken(start: Start) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        process = start("--host", "127.0.0.1", "--port", str(port))
        output, _ = process.communicate(timeout=30)
    assert process.returncode == 1
    assert f"cannot listen on 127.0.0.1:{port}: " in output
    assert "--port 0 selects a free port" in output


@pytest.mark.slow
def test_a_layout_by_its_name(start: Start) -> None:
    link = link_in(first_line(start("--port", "0")))
    assert link_in(first_line(start("--layout", "Mobile robot"))) == f"{link}#Mobile%20robot"
    assert link_in(first_line(start("rqt", "--layout", "Tutorial"))) == f"{link}#Tutorial"


@pytest.mark.slow
def test_other_machines_are_warned_of(start: Start) -> None:
    process = start("--port", "0", "--host", "0.0.0.0")
    assert process.stdout is not None
    lines = [process.stdout.readline() for _ in range(2)]
    assert any("anyone with the link" in line for line in lines)


@pytest.mark.slow
def test_it_ends_while_the_master_is_away(start: Start, environ: dict[str, str]) -> None:
    master = Master(port=0, bind_host="127.0.0.1")
    master.start()
    process = start("--port", "0", ROS_MASTER_URI=master.uri)
    link = link_in(first_line(process))
    with connect(link.replace("http", "ws", 1).replace("/?", "/ws?"), open_timeout=20) as page:
        while True:  # until the server has found the master
            page.send('{"call": "params.tree", "id": 1}')
            page.send('{"open": "system", "stream": 1}')
            if "result" in json.loads(page.recv(timeout=20)):
                break
        master.stop()
        for number in range(40):  # more than there are threads
            topic = {"topic": f"/t{number}", "type": "std_msgs/Float64", "value": {}}
            page.send(json.dumps({"open": "message", "stream": 10 + number, "args": topic}))
            page.send(json.dumps({"call": "topics.publish", "id": 100 + number, "args": topic}))
        page.send('{"call": "page.about", "id": 7}')
        while json.loads(page.recv(timeout=30)).get("id") != 7:
            pass
    process.send_signal(signal.SIGTERM)
    assert process.wait(30) == 0


@pytest.mark.slow
def test_names_of_the_stock_programs(start: Start) -> None:
    names = stock_names()
    for name in ("rqt_plot", "rxplot", "rqt_console", "rxgraph", "rviz", "rqt"):
        assert names[name] == ("web", name)
    assert "image_view" not in names  # a program of a package only, as in stock ROS
    server = start("--port", "0")
    link = link_in(first_line(server))
    for words, panel in (
        (["rqt_console", "--force-discover", "-ht", "--clear-config"], "console"),
        (["rxgraph"], "graph"),
        (["rviz", "-s", "splash.png", "-l", "--opengl", "3"], "scene"),
        (["rqt_tf_tree", "-b", "pyqt"], "frames"),
    ):
        assert link_in(first_line(start(*words))) == f"{link}#{panel}"
    assert link_in(first_line(start("rqt"))) == link
    other = start("rqt", "-s", "rqt_plot", "-p", "mine", "/a/x")
    assert first_line(other).startswith("rqt: the page cannot read rqt perspectives")
    assert settings_in(link_in(first_line(other))) == {"panel": "plot", "settings": {"curves": ["/a/x"]}}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "panel", "settings"),
    [
        (["rqt_plot", "rqt_plot", "/a/x:y"], "plot", {"curves": ["/a/x", "/a/y"]}),
        (["image_view", "image_view", "image:=/camera/image_raw"], "image", {"topic": "/camera/image_raw"}),
        (["image_view", "image_view", "image:=/c", "compressed"], "image", {"topic": "/c/compressed"}),
        (["image_view", "image_view", "image:=c", "_image_transport:=compressed"], "image", {"topic": "/c/compressed"}),
        (["image_view", "image_view", "/r/image:=c", "__ns:=/r"], "image", {"topic": "/r/c"}),
        (["rqt_image_view", "rqt_image_view", "/camera"], "image", {"topic": "/camera"}),
        (["rqt_reconfigure", "rqt_reconfigure"], "params", {"reconfigure": ""}),
        # By its path: where Debian's rviz is installed, too, the name means that one.
        ([str(PACKAGES / "rviz" / "scripts" / "rviz"), "-f", "odom"], "scene", {"fixed": "odom"}),
    ],
)
def test_programs_of_packages(
    start: Start, environ: dict[str, str], words: list[str], panel: str, settings: dict[str, object]
) -> None:
    link = link_in(first_line(start("--port", "0")))
    done = subprocess.run(
        [sys.executable, *words] if os.path.isabs(words[0]) else [sys.executable, "-m", "pyros1", "run", *words],
        env={**os.environ, **environ, "BROWSER": "true", "ROS_PACKAGE_PATH": "", "CMAKE_PREFIX_PATH": ""},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    found = link_in(done.stdout)
    assert found.startswith(f"{link}#{panel}=")
    assert settings_in(found) == {"panel": panel, "settings": settings}


@pytest.mark.slow
def test_a_node_of_a_launch_file_stays(start: Start, environ: dict[str, str], tmp_path: Path) -> None:
    """Two programs with windows in one file: one serves the page, both stay, with their names; no display is needed."""
    file = tmp_path / "show.launch"
    file.write_text(
        '<launch><node name="show" pkg="rqt_bag" type="rqt_bag" required="true" output="screen"/>'
        '<node name="curves" pkg="rqt_plot" type="rqt_plot" args="/a/x" required="true" output="screen"/></launch>'
    )
    plain = {name: value for name, value in os.environ.items() if name not in ("BROWSER", "DISPLAY", "WAYLAND_DISPLAY")}
    process = subprocess.Popen(
        [sys.executable, "-m", "pyros1", "launch", str(file)],
        env={**plain, **environ},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    try:
        assert process.stdout is not None
        links = []
        while len(links) < 2:
            line = process.stdout.readline()
            assert line, links
            if "open the link yourself: http://" in line:
                links.append(link_in(line))
        assert len({link.partition("#")[0] for link in links}) == 1
        assert sorted(link.partition("#")[2].partition("=")[0] for link in links) == ["bag", "plot"]
        with contextlib.closing(MasterClient("/test", environ["ROS_MASTER_URI"])) as client:
            until = time.monotonic() + 30
            while not {"/show", "/curves"} <= {*Graph(client).state().nodes()}:
                assert process.poll() is None and time.monotonic() < until
                threading.Event().wait(0.1)
        process.send_signal(signal.SIGINT)
        rest, _ = process.communicate(timeout=60)
        assert process.returncode == 0 and "Traceback" not in rest and "escalat" not in rest
    finally:
        if process.poll() is None:
            process.kill()
            process.communicate()


@pytest.mark.slow
def test_a_panel_needs_not_the_usual_port(environ: dict[str, str]) -> None:
    """Another program may have it, or the page of another master."""
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        code = f"import pyros1.cli.commands.web as web; web.WEB_PORT = {port}; from pyros1.cli.main import entry;"
        code += "entry(['pyros1', 'web', 'rqt_console', '--host', '127.0.0.1'])"
        process = subprocess.Popen(
            [sys.executable, "-c", code],
            env={**os.environ, **environ, "BROWSER": "true"},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        line = first_line(process)
        process.terminate()
        process.communicate(timeout=30)
    found = re.search(r"http://127.0.0.1:(\d+)/", line)
    assert found and int(found[1]) != port, line
