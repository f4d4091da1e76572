"""launch.running.session: the parameters of a launch, and what it leaves at a master that goes on."""

from __future__ import annotations

import io
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from pyros1.finding.packages import PackageIndex
from pyros1.ground.errors import LaunchError
from pyros1.launch.plan import ParamFileAction, Plan
from pyros1.launch.running.console import Console
from pyros1.launch.running.options import Options
from pyros1.launch.running.session import Session
from pyros1.master.server import Master
from pyros1.net.master_client import MasterClient

URIS = "/roslaunch/uris"
Run = Callable[..., str]


@pytest.fixture
def client(master: Master) -> Iterator[MasterClient]:
    client = MasterClient("/test", master.uri)
    yield client
    client.close()


@pytest.fixture
def run(environ: dict[str, str], tmp_path: Path) -> Run:
    """Return a function that runs a plan until all has been started, and returns what was said."""
    environ = {**environ, "PATH": os.environ["PATH"], "ROS_HOME": str(tmp_path / "home")}

    def run(plan: Plan, while_up: Callable[[], object] = lambda: None, **options: Any) -> str:
        said = io.StringIO()

        def end() -> None:
            while_up()
            session.stop("enough")

        console = Console(said, said, title=False)
        options = {"show_summary": False, **options}
        session = Session(plan, Options(**options), PackageIndex(environ), environ, console, end)
        session.run()
        return said.getvalue()

    return run


def test_parameters_are_cleared_before_others_are_set(run: Run, client: MasterClient) -> None:
    """All of them only if a namespace is named: the parameters of others are below '/', too."""
    client.set_param("/arm/old", 1)
    client.set_param("/theirs", 2)
    run(Plan(params={"/arm/new": 3}, clear_params=["/", "/arm/"]))
    assert (client.get_param("/arm"), client.get_param("/theirs")) == ({"new": 3}, 2)


def test_parameters_are_dumped_and_deleted_before_others_are_set(
    run: Run, client: MasterClient, tmp_path: Path
) -> None:
    client.set_param("/arm", {"gain": 1.5})
    actions = [
        ParamFileAction("dump", "/arm", str(tmp_path / "arm.yaml")),
        ParamFileAction("delete", "/arm"),
        ParamFileAction("delete", "/none"),
        ParamFileAction("dump", "/none", str(tmp_path / "none.yaml")),
    ]
    said = run(Plan(params={"/arm/new": 3}, actions=actions))
    assert (tmp_path / "arm.yaml").read_text() == "gain: 1.5\n" and not (tmp_path / "none.yaml").exists()
    assert client.get_param("/arm") == {"new": 3}
    assert [line.startswith("ERROR: ") and "/none" in line for line in said.splitlines()].count(True) == 2, said


def test_a_dump_that_cannot_be_written_ends_the_launch(run: Run, client: MasterClient, tmp_path: Path) -> None:
    client.set_param("/arm", 1)
    path = str(tmp_path / "no" / "arm.yaml")
    with pytest.raises(LaunchError, match=f"cannot dump /arm to {path}: No such file or directory"):
        run(Plan(actions=[ParamFileAction("dump", "/arm", path)]))


def test_a_value_that_cannot_be_sent_is_named(run: Run) -> None:
    with pytest.raises(LaunchError, match=r"parameter /b: None \(null\) cannot be sent over XML-RPC"):
        run(Plan(params={"/a": 1, "/b": None}))


def test_a_parameter_that_the_master_refuses_is_named(run: Run, client: MasterClient) -> None:
    with pytest.raises(LaunchError, match="cannot set parameter /: "):
        run(Plan(params={"/a": 1, "/": 2}))


def test_warnings_of_the_files_are_shown_under_the_summary(run: Run) -> None:
    said = run(Plan(params={"/a": 1}, warnings=["look at this"]), show_summary=True)
    assert said.index("PARAMETERS\n * /a: 1\n") < said.index("WARNING: look at this")


def test_a_launch_names_itself_at_the_master_while_it_runs(run: Run, client: MasterClient) -> None:
    found: list[Any] = []
    run(Plan(), lambda: found.append(client.get_param(URIS)))
    ((uri,),) = [list(names.values()) for names in found]
    assert uri.startswith("http://localhost:") and client.get_param(URIS) == {}


def test_a_launch_ends_though_its_name_or_its_master_is_gone(run: Run, master: Master, client: MasterClient) -> None:
    assert run(Plan(), lambda: client.delete_param(URIS)).endswith("shutting down processing monitor complete\n")
    assert run(Plan(), master.stop).endswith("shutting down processing monitor complete\n")
