"""Modules from .cfg files, without a build; stock: interop/modules/test_dynamic_reconfigure.py."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from programs import run

MANIFEST = "<package><name>robot</name></package>"
CFG = """
from dynamic_reconfigure.parameter_generator_catkin import *
gen = ParameterGenerator()
gen.add("rate", double_t, 1, "in Hz", 10, 0.1, 100)
mode = gen.enum([gen.const("Slow", int_t, 0, "slow"), gen.const("Fast", int_t, 1, "fast")], "of the motor")
gen.add("mode", int_t, 2, "of the motor", 1, 0, 1, edit_method=mode)
exit(gen.generate("robot", "robot", "Motor"))
"""


@pytest.fixture
def package(tmp_path: Path, environ: dict[str, str]) -> Path:
    folder = tmp_path / "src" / "robot"
    (folder / "cfg" / "deeper").mkdir(parents=True)
    (folder / "package.xml").write_text(MANIFEST)
    environ["ROS_PACKAGE_PATH"] = str(tmp_path / "src")
    return folder


@pytest.mark.parametrize("place", ["cfg", "cfg/deeper", "config"])
def test_a_module_from_a_cfg_file(package: Path, environ: dict[str, str], place: str) -> None:
    (package / place).mkdir(exist_ok=True)
    (package / place / "Motor.cfg").write_text(CFG)
    program = """
from robot.cfg import MotorConfig
import robot.cfg.MotorConfig
print(MotorConfig.defaults, MotorConfig.min, MotorConfig.max, MotorConfig.level, MotorConfig.type)
print(MotorConfig.all_level, MotorConfig.Motor_Slow, MotorConfig.Motor_Fast, robot.cfg.MotorConfig is MotorConfig)
"""
    assert run(program, environ).splitlines() == [
        "{'rate': 10.0, 'mode': 1} {'rate': 0.1, 'mode': 0} {'rate': 100.0, 'mode': 1} "
        "{'rate': 1, 'mode': 2} {'rate': 'double', 'mode': 'int'}",
        "3 0 1 True",
    ]


@pytest.mark.parametrize("name", ["parameter_generator_catkin", "parameter_generator"])
def test_the_file_has_our_generator_whichever_library_the_program_has(
    package: Path, environ: dict[str, str], tmp_path: Path, name: str
) -> None:
    """The sources of stock's library may be on PYTHONPATH: its generator writes files for a build."""
    library = tmp_path / "sources" / "dynamic_reconfigure"
    library.mkdir(parents=True)
    (library / "__init__.py").write_text("")
    (library / f"{name}.py").write_text("class ParameterGenerator: pass\nint_t = double_t = 'theirs'\n")
    (library / "encoding.py").write_text("def extract_params(group): return 'theirs'\n")
    (package / "cfg" / "Motor.cfg").write_text(CFG.replace("parameter_generator_catkin", name))
    program = f"""
import sys
sys.path.insert(0, {str(tmp_path / "sources")!r})
from dynamic_reconfigure.{name} import double_t
from robot.cfg import MotorConfig
from dynamic_reconfigure.{name} import int_t
print(MotorConfig.defaults, MotorConfig.Motor_Fast, MotorConfig.extract_params(None), double_t, int_t)
"""
    assert run(program, environ) == "{'rate': 10.0, 'mode': 1} 1 theirs theirs theirs\n"


def test_a_package_with_an_own_python_module(package: Path, environ: dict[str, str]) -> None:
    (package / "src" / "robot").mkdir(parents=True)
    (package / "src" / "robot" / "__init__.py").write_text("name = 'the robot'")
    (package / "cfg" / "Motor.cfg").write_text(CFG)
    program = "import robot; from robot.cfg import MotorConfig; print(robot.name, MotorConfig.all_level)"
    assert run(program, environ) == "the robot 3\n"


@pytest.mark.parametrize(
    ("text", "error"),
    [
        ("print 5", "Motor.cfg, line 1: Missing parentheses"),
        ("import nothing_like_this", "Motor.cfg: ModuleNotFoundError: No module named 'nothing_like_this'"),
        ("pass", "Motor.cfg does not call generate()"),
        (CFG.replace("10, 0.1", "'x', 0.1"), "TypeError: 'rate' has type double, but default is 'x'"),
    ],
)
def test_files_that_describe_nothing(package: Path, environ: dict[str, str], text: str, error: str) -> None:
    (package / "cfg" / "Motor.cfg").write_text(text)
    assert f"{error}" in run("import robot.cfg.MotorConfig", environ, code=1)


def test_a_cfg_file_that_never_ends_is_none(package: Path, environ: dict[str, str]) -> None:
    os.mkfifo(package / "cfg" / "Pipe.cfg")
    (package / "cfg" / "Motor.cfg").write_bytes(b"\0")
    program = """
import robot.cfg.{}Config
"""
    out = run(program.format("Pipe"), environ, code=1)
    assert "No module named 'robot.cfg.PipeConfig'" in out or "has no robot.cfg" in out
    assert "Motor.cfg: source code string cannot contain null bytes" in run(program.format("Motor"), environ, code=1)


def test_modules_that_there_are_not(package: Path, environ: dict[str, str]) -> None:
    (package / "cfg" / "Motor.cfg").write_text(CFG)
    assert "No module named 'robot.cfg.OtherConfig'" in run("import robot.cfg.OtherConfig", environ, code=1)


def test_what_pyros1_does_not_make(package: Path, environ: dict[str, str]) -> None:
    said = run(CFG, environ, code=1)
    assert (
        "pyros1 does not generate files from .cfg files, and does not need them: import PACKAGE.cfg.NAMEConfig" in said
    )
    program = "from dynamic_reconfigure.parameter_generator_catkin import *\nParameterGenerator().generatecpp()"
    assert "pyros1 has no dynamic_reconfigure ParameterGenerator.generatecpp" in run(program, environ, code=1)
