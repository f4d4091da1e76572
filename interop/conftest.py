"""Fixtures of the interop tests: real masters and real peers, see README.md."""

from __future__ import annotations

import importlib.util
import itertools
import os
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent / "peers"))
pytest.register_assert_rewrite("harness", "cases", "faces")

from harness import SOURCE, Master, Peer, free_port, missing_stock  # noqa: E402  found through the path set above

if importlib.util.find_spec("pyros1") is None:
    sys.path.insert(0, str(SOURCE))


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--ours", default="pyros1", help="stand-in for pyros1 that checks the tests themselves")
    parser.addoption("--masters", default="ours,stock", help="the masters to run under: ours, stock or both")
    parser.addoption("--long", action="store_true", help="repeat faults many times, which takes minutes")


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", "ours_only: says something about pyros1 that no stand-in can show")


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    if "master" in metafunc.fixturenames:
        module = metafunc.module
        wanted = getattr(module, "MASTERS", ("ours", "stock"))
        kinds = [kind for kind in metafunc.config.getoption("--masters").split(",") if kind in wanted] or list(wanted)
        owner = module.__name__ if getattr(module, "OWN_MASTER", False) else ""
        metafunc.parametrize("master", [(kind, owner) for kind in kinds], indirect=True, ids=kinds, scope="session")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    here = Path(__file__).resolve().parent
    reason = missing_stock()
    if reason and os.environ.get("CI", "").lower() not in ("true", "1") and not os.environ.get("PYROS1_REQUIRE_STOCK"):
        for item in items:
            if here in item.path.parents:
                item.add_marker(pytest.mark.skip(reason=reason))
    if config.getoption("--ours") != "pyros1":
        for item in items:
            if item.get_closest_marker("ours_only"):
                item.add_marker(pytest.mark.skip(reason="needs pyros1 itself"))


@pytest.fixture(scope="session")
def running_masters(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, Master]]:
    """The masters that the session has started; all end with it."""
    reason = missing_stock()
    if reason:
        pytest.fail(reason)
    running: dict[str, Master] = {}
    yield running
    for master in running.values():
        master.close()


@pytest.fixture(scope="session")
def new_master(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Master]:
    """Makes a master of a kind, not yet started, on a free port with a folder of its own."""
    return lambda kind: Master(kind, tmp_path_factory.mktemp(f"{kind}_master"), free_port())


@pytest.fixture(scope="session")
def master(
    request: pytest.FixtureRequest, running_masters: dict[str, Master], new_master: Callable[[str], Master]
) -> Master:
    """A running master with rosout, ``ours`` or ``stock``, shared by all tests of the session.

    A module may say ``MASTERS = ("ours",)`` if its tests do not depend on the kind, and ``OWN_MASTER = True`` if they
    look at the whole system, or leave dead nodes behind: then it shares its masters with no other module.
    """
    kind, owner = request.param
    key = f"{kind} {owner}"
    if key not in running_masters:
        running_masters[key] = started = new_master(kind)
        started.start()
    return running_masters[key]


@pytest.fixture
def launcher(master: Master) -> Iterator[Master]:
    """The master, for tests that start processes of their own: what they started ends with the test."""
    mark = len(master.processes)
    yield master
    master.close_since(mark)


@pytest.fixture
def own_master(new_master: Callable[[str], Master]) -> Iterator[Callable[[str], Master]]:
    """Makes masters for one test alone: call it with ``ours`` or ``stock``, then ``start()`` the result."""
    made: list[Master] = []

    def make(kind: str) -> Master:
        made.append(new_master(kind))
        return made[-1]

    yield make
    for each in made:
        each.close()


@pytest.fixture
def long(request: pytest.FixtureRequest) -> bool:
    """Whether to repeat faults many times."""
    return bool(request.config.getoption("--long"))


@pytest.fixture
def ours_kind(request: pytest.FixtureRequest) -> str:
    """``pyros1``, unless a stand-in checks the harness."""
    return str(request.config.getoption("--ours"))


@pytest.fixture
def ours(ours_kind: str, master: Master) -> Peer:
    """The pyros1 peer under *master*."""
    return master.shared("our", ours_kind)


@pytest.fixture
def peer(request: pytest.FixtureRequest, master: Master) -> Peer:
    """The stock peer under *master*, of the kind that the test's class names."""
    return master.shared("stock", request.cls.kind)


_numbers = itertools.count(1)


@pytest.fixture
def topic() -> str:
    """A topic, service or parameter name that no other test uses."""
    return f"/interop/n{next(_numbers)}"
