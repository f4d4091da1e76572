"""The rules of the house: which room may import which, what is pure, what is at the top level, what README claims."""

from __future__ import annotations

import ast
import os
import re
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest
import yaml

import pyros1

pytestmark = pytest.mark.once

ROOT = Path(__file__).resolve().parents[1]
SOURCE = ROOT / "src" / "pyros1"

# A room may import the rooms on lower levels, and itself.
LEVELS = [
    {"ground"},
    {"values", "wire", "msgs"},
    {"finding", "net", "ros2_types"},
    {"master", "node"},
    {"graph", "aio", "tf", "observe"},
    {"actions", "filters", "reconfigure", "diagnostics", "urdf"},
    {"launch", "bag", "topic_tools", "turtlesim", "robot_nodes"},
    {"doctor", "test_nodes", "testing", "guide", "drop_in"},
    {"web", "bridge"},
    {"ros2"},
    {"cli"},
]
LEVEL = {room: level for level, rooms in enumerate(LEVELS) for room in rooms}
OUTSIDE = {"__init__", "__main__", "packages"}  # the public API, the start of `python -m pyros1`, users' programs

IMPURE = {"socket", "selectors", "select", "threading", "time", "subprocess", "asyncio", "signal", "multiprocessing"}
IMPURE |= {"os", "pathlib", "shutil", "tempfile"}
PURE = [
    f"ground/{name}" for name in ("errors.py", "names.py", "timing.py", "expressions", "suggest.py", "terminal_text.py")
]
PURE += ["values", "wire", "msgs"]
PURE += [f"urdf/{name}.py" for name in ("model", "reading", "kinematics", "joints", "tf_encoder")]
PURE += [
    f"robot_nodes/laser_filters/{name}.py"
    for name in ("scans", "value_filters", "shape_filters", "neighbour_filters", "time_filters", "chain")
]
PURE += [f"robot_nodes/pointcloud_to_laserscan/{name}.py" for name in ("clouds", "projection")]
PURE += ["robot_nodes/depthimage_to_laserscan/conversion.py"]
PURE += [
    f"robot_nodes/diagnostic_aggregator/{name}.py"
    for name in ("match_ways", "patterns", "matching", "analyzers", "configuration", "aggregator")
]
PURE += [f"turtlesim/{name}.py" for name in ("turtle", "canvas", "world", "blocks", "finding")]
DRIVE = "shared/twist_sources joy/events joy/joystick teleop_twist_joy/teleop twist_mux/arbiter yocs_cmd_vel_mux/config"
DRIVE += " yocs_cmd_vel_mux/selector yocs_velocity_smoother/smoother interactive_marker_twist_server/handle"
PURE += [f"robot_nodes/{name}.py" for name in DRIVE.split()]
IMU = "shared/quaternions shared/imu_readings imu_filter_madgwick/world imu_filter_madgwick/madgwick"
PURE += [f"robot_nodes/{name}.py" for name in f"{IMU} imu_complementary_filter/complementary".split()]
PURE += [f"robot_nodes/map_server/{name}.py" for name in ("pgm", "description", "cells", "messages", "errors")]
PURE += [f"robot_nodes/flat_world/{name}.py" for name in ("walls", "drive", "sensors", "camera", "world")]
PURE += [f"robot_nodes/robot_localization/{name}.py" for name in ("motion", "ekf", "ukf", "control", "estimator")]
PURE += [f"robot_nodes/robot_localization/{name}.py" for name in ("sensors", "inputs", "settings", "output")]
PURE += [f"robot_nodes/robot_localization/{name}.py" for name in ("utm", "local_plane", "navsat")]
PURE += [f"bridge/{name}" for name in ("names.py", "conversions", "protocol", "exchange", "rules")]
PURE += [f"bridge/transport/{name}.py" for name in ("link", "endpoints", "queues", "pacer", "access_control")]
PURE += [
    f"bridge/plugin_ros1/{name}.py"
    for name in ("keys", "beacons", "rules", "plan", "state", "arrivals", "config", "explanation")
]


PURE += [
    f"ros2_types/{name}.py"
    for name in (
        "model",
        "definitions",
        "nesting",
        "interfaces",
        "type_hash",
        "ros1_definitions",
        "mapping",
        "legal_names",
    )
]
PURE += [f"robot_nodes/rosserial_python/{name}.py" for name in ("frames", "session", "parameters", "log_budget")]
PURE += [f"robot_nodes/image_proc/{name}.py" for name in ("pixels", "colours", "camera", "remap", "resample", "sizes")]
PURE += [f"robot_nodes/usb_cam/{name}.py" for name in ("calibration", "controls")]
PURE += ["ros2_types/transcoding"]
PURE += ["robot_nodes/teleop_twist_keyboard/driver.py", "finding/nodelet_programs.py"]
PURE += ["web/rosbridge_server/settings.py", "web/web_video_server/requests.py", "web/web_video_server/pages.py"]
PURE += ["web/web_video_server/video_options.py"]
PURE += [f"ros2/zenoh/{name}.py" for name in ("names", "qos", "attachments", "tokens", "graph")]
PURE += [f"ros2/bridge/{name}.py" for name in ("plan", "rules", "arrivals")]


def sources() -> list[Path]:
    return sorted(path for path in SOURCE.rglob("*.py") if "packages" not in path.relative_to(SOURCE).parts)


def room_of(path: Path) -> str:
    return path.relative_to(SOURCE).parts[0].removesuffix(".py")


@cache
def parsed(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


@cache
def imports(path: Path) -> list[str]:
    """Return the full names of the modules that a file imports, those for type checkers only included."""
    found: list[str] = []
    for node in ast.walk(parsed(path)):
        if isinstance(node, ast.Import):
            found += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0 and node.module, f"{path}: write imports in full"
            found += [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
    return found


@cache
def imports_for_types(path: Path) -> set[str]:
    """Return the full names of the modules that a file imports for type checkers only."""
    nodes = [node for node in ast.walk(parsed(path)) if isinstance(node, ast.ImportFrom)]
    tests = [node for node in parsed(path).body if isinstance(node, ast.If)]
    guarded = [inner for test in tests if ast.unparse(test.test) == "TYPE_CHECKING" for inner in test.body]
    return {node.module or "" for node in nodes if node in guarded} - {
        node.module or "" for node in nodes if node not in guarded
    }


def module_of(path: Path) -> str:
    """Return the full name of a file's module."""
    return ".".join(path.relative_to(SOURCE.parent).with_suffix("").parts).removesuffix(".__init__")


@pytest.mark.slow
def test_imports_run_one_way() -> None:
    """Feature: imports go one way, and the core does no I/O"""
    for path in sources():
        room = room_of(path)
        if room in OUTSIDE:
            continue
        assert room in LEVEL, f"{room} has no place in LEVELS"
        for name in imports(path):
            parts = name.split(".")
            if parts[0] != "pyros1" or len(parts) == 1 or parts[1] not in LEVEL:
                continue
            target = parts[1]
            allowed = target == room or LEVEL[target] < LEVEL[room]
            assert allowed, f"{path.relative_to(ROOT)} imports {name}: {room} may not import {target}"


@pytest.mark.slow
def test_no_circles() -> None:
    """No file needs, by way of others, one that needs it.

    Imports for type checkers count, too, except between two files of one folder.
    """
    modules = {module_of(path): path for path in sources()}
    needs: dict[str, set[str]] = {}
    for module, path in modules.items():
        names = {*imports(path)} & {*modules}
        # "from pyros1.bag import api" needs api, and of the package no more than importing any of its modules does.
        deeper = {name.rpartition(".")[0] for name in names}
        folder = module.rpartition(".")[0]
        neighbours = {name for name in imports_for_types(path) if name.rpartition(".")[0] == folder}
        needs[module] = names - {module} - neighbours - {name for name in names if name in deeper}
    left = dict(needs)
    while ready := [module for module, others in left.items() if not others & left.keys()]:
        for module in ready:
            del left[module]
    while needing := [name for name in left if not any(name in others for others in left.values())]:
        for name in needing:  # they need a circle, and are in none
            left.pop(name)
    assert not left, "\n".join(f"{name} -> {sorted(needs[name] & left.keys())}" for name in sorted(left))


@pytest.mark.parametrize("name", PURE)
def test_pure_rooms_import_no_io(name: str) -> None:
    target = SOURCE / name
    assert target.exists()
    for path in [target] if target.is_file() else sorted(target.rglob("*.py")):
        for module in imports(path):
            assert module.split(".")[0] not in IMPURE, f"{path.relative_to(ROOT)} imports {module}"


@pytest.mark.slow
def test_modules_hold_no_mutable_state() -> None:
    """No `global` statement, and no empty container that waits to be filled, at module level (but in drop_in/)."""
    for path in sources():
        if room_of(path) == "drop_in":
            continue
        tree = parsed(path)
        assert not any(isinstance(node, ast.Global) for node in ast.walk(tree)), f"{path}: global"
        for statement in tree.body:
            value = statement.value if isinstance(statement, (ast.Assign, ast.AnnAssign)) else None
            if isinstance(value, (ast.List, ast.Dict, ast.Set)):
                empty = not (value.keys if isinstance(value, ast.Dict) else value.elts)
                assert not empty, f"{path}:{statement.lineno}: an empty container at module level"


def test_every_source_file_is_one_idea_long() -> None:
    written = [path for path in sources() if path != SOURCE / "cli" / "index.py"]  # which is generated
    long = {str(p.relative_to(ROOT)): n for p in written if (n := len(p.read_text().splitlines())) > 450}
    assert not long, f"split these: {long}"


def test_what_runs_elsewhere_names_what_there_is() -> None:
    """Workflows and forms are YAML, and the commands in them name extras and files of this project."""
    files = [*(ROOT / ".github").rglob("*.yml"), ROOT / "CITATION.cff"]
    assert len(files) > 4
    for path in files:
        assert isinstance(yaml.safe_load(path.read_text(encoding="utf-8")), dict), path
    text = "".join(path.read_text(encoding="utf-8") for path in [*files, ROOT / ".github" / "Dockerfile"])
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    extras = re.findall(r"[.e]\[(\w+)\]'", text)
    assert extras and all(f"\n{extra} = [" in project for extra in extras)
    assert re.findall(r"run: (tests/\w+)", text) == ["tests/run"] and (ROOT / "tests" / "run").is_file()
    assert "pyros1 wtf --report" in text


def test_the_version_is_in_one_place_and_the_citation_says_the_same() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert citation["version"] == pyros1.__version__


def test_what_the_release_adds_is_part_of_the_project(tmp_path: Path) -> None:
    tomllib = pytest.importorskip("tomllib", reason="Python 3.10 has none")
    flow = yaml.safe_load((ROOT / ".github" / "workflows" / "release.yml").read_text(encoding="utf-8"))
    adding = next(
        step["run"] for step in flow["jobs"]["build"]["steps"] if step.get("name", "").startswith("addresses")
    )
    (tmp_path / "pyproject.toml").write_bytes((ROOT / "pyproject.toml").read_bytes())
    known = {"GITHUB_REPOSITORY": "someone/pyros1", "GITHUB_REPOSITORY_OWNER": "someone", "PATH": os.environ["PATH"]}
    subprocess.run(["bash", "-c", adding], cwd=tmp_path, env=known, check=True)
    project = tomllib.loads((tmp_path / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert project["urls"] == {
        "Source": "https://github.com/someone/pyros1",
        "Documentation": "https://someone.github.io/pyros1",
    }


def test_the_source_distribution_has_nothing_that_was_built() -> None:
    grafted, pruned = (
        {line.split()[1] for line in (ROOT / "MANIFEST.in").read_text().splitlines() if line.startswith(f"{command} ")}
        for command in ("graft", "prune")
    )
    built = {"interop/build", "tests/javascript/node_modules"}  # by interop/setup and tests/javascript/check
    assert {name for name in built if name.partition("/")[0] in grafted} == pruned


def test_top_level_folders() -> None:
    allowed = {"src", "tests", "launch", "interop", "build", "dist"}
    found = {path.name for path in ROOT.iterdir() if path.is_dir() and not path.name.startswith((".", "__"))}
    assert found <= allowed, f"no other folders at the top level: {found - allowed}"


@pytest.mark.slow
def test_the_page_of_features_is_current() -> None:
    command = [sys.executable, str(ROOT / "interop" / "features.py"), "--check"]
    assert subprocess.run(command, timeout=60, check=False).returncode == 0, "run python interop/features.py"
    assert (ROOT / "interop" / "features.md").read_text(encoding="utf-8").count("\n| ") >= 100


HOWTO_TESTS = [
    (page.name, reference)
    for page in sorted((SOURCE / "guide" / "howto").glob("*.md"))
    for reference in re.findall(r"`((?:tests|interop)/[\w/]+\.py(?:::\w+)?)`", page.read_text(encoding="utf-8"))
]


@pytest.mark.parametrize(("page", "reference"), HOWTO_TESTS)
def test_tests_that_how_to_pages_name_exist(page: str, reference: str) -> None:
    file, _, name = reference.partition("::")
    path = ROOT / file
    assert path.exists(), f"{page}: there is no {file}"
    assert not name or re.search(rf"def {re.escape(name)}\b", path.read_text(encoding="utf-8")), f"{page}: {reference}"


# Names with an underscore that stock's message classes have, too: programs use them.
MESSAGE_NAMES = {"_type", "_md5sum", "_full_text", "_slot_types", "_has_header", "_connection_header", "_buff"}
MESSAGE_NAMES |= {"_request_class", "_response_class", "_get_types", "_check_types"}
STANDARD = {"_replace", "_asdict", "_exit", "_current_frames"}  # of named tuples, os and sys


def is_private(name: str) -> bool:
    return name.startswith("_") and not name.endswith("__") and name not in MESSAGE_NAMES | STANDARD


def names_used(node: ast.AST) -> list[str]:
    """Return the names that a piece of a test uses: as attributes, imports, patches or in programs that it runs."""
    if isinstance(node, ast.Attribute):
        own = isinstance(node.value, ast.Name) and node.value.id == "self"
        return [] if own else [node.attr]
    if isinstance(node, ast.ImportFrom):
        # A module whose name begins with _ is private to its folder of verbs: its parts are tested all the same.
        folder = SOURCE.parent.joinpath(*(node.module or "").split("."))
        return [alias.name for alias in node.names if not (folder / f"{alias.name}.py").exists()]
    if isinstance(node, ast.Call) and ast.unparse(node.func).endswith(("setattr", "getattr")):
        words = [each.value for each in node.args[:2] if isinstance(each, ast.Constant)]
        return [str(word).rpartition(".")[2] for word in words]
    if isinstance(node, ast.Constant) and isinstance(node.value, str) and "import" in node.value:
        # Programs import std_msgs.msg._String, a module that stock's generator makes.
        return re.findall(r"(?<!self)(?<!\.msg)(?<!\.srv)\.(_\w+)", node.value)
    return []


@pytest.mark.slow
def test_tests_use_public_names_only() -> None:
    """What a test needs to see of an internal class has a public name and a docstring there; see tests/parts.py."""
    for path in sorted((ROOT / "tests").rglob("*.py")):
        for node in ast.walk(parsed(path)):
            for name in names_used(node):
                assert not is_private(name), f"{path}:{getattr(node, 'lineno', 0)}: {name}"


def test_tests_lie_as_the_rooms_do() -> None:
    """The folders of tests are those of the source, except for what serves many rooms."""
    rooms = {folder.relative_to(ROOT / "tests") for folder in (ROOT / "tests").rglob("*") if folder.is_dir()}
    rooms = {
        room
        for room in rooms
        if "__pycache__" not in room.parts and room.parts[0] not in ("fuzz", "javascript", "mutation", "schedules")
    }
    assert not {str(room) for room in rooms if not (SOURCE / room).is_dir()}


CODE = re.compile(r"\b([MSTNPCGLXBO])(\d{2,3})(?:-[MSTNPCGLXBO]?(\d{2,3}))?\b")


def behaviour_codes(text: str) -> set[str]:
    """Return the codes of facts about stock that comments name in parentheses: ``(T55)``, ``(M01, M04-M06)``."""
    found = set()
    for inside in re.findall(r"\(([^()\n]*)\)", text):
        for letter, first, last in CODE.findall(inside):
            found |= {f"{letter}{number:0{len(first)}}" for number in range(int(first), int(last or first) + 1)}
    return found


def facts() -> dict[str, list[str]]:
    """Return the rows of the table of facts by their codes: fact, source, tests."""
    lines = (ROOT / "interop" / "behaviour.md").read_text(encoding="utf-8").splitlines()
    rows = [[cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]] for line in lines if line.startswith("|")]
    return {code: cells for code, *cells in rows if CODE.fullmatch(code)}


def test_codes_of_facts_are_explained() -> None:
    known = facts().keys()
    for path in sources():
        assert behaviour_codes(path.read_text("utf-8")) <= known, path


def test_each_fact_names_tests_that_there_are_or_says_why_not() -> None:
    for code, (_, _, cell) in facts().items():
        named = re.findall(r"`((?:tests|interop)/[^`:]+)(?:::(\w+))?`", cell)
        assert named or re.match(r"background: \w", cell), f"{code} has no test"
        for file, name in named:
            text = (ROOT / file).read_text(encoding="utf-8")
            assert not name or re.search(rf"def {name}\b", text), f"{code}: no {name} in {file}"


def test_all_tests_beside_stock_are_run() -> None:
    text = (ROOT / "tests" / "run").read_text(encoding="utf-8")
    run = set()
    for line in re.findall(r"(?:start_tests|turn) .*", text):
        words = " ".join(re.findall(r"interop/[^\s)]+", line))
        done = subprocess.run(["bash", "-c", f"echo {words}"], cwd=ROOT, capture_output=True, text=True, check=True)
        run |= {test for folder in done.stdout.split() for test in (ROOT / folder).rglob("test_*.py")}
    assert run == set((ROOT / "interop").rglob("test_*.py"))
