"""The import hook: ``from pyros1.msgs.<package>.msg import Type``."""

from __future__ import annotations

import importlib
import sys
import threading
from pathlib import Path
from typing import Any

import pytest

import pyros1.msgs
from pyros1.finding.importing import MessageFinder
from pyros1.ground import msgs_imports
from pyros1.ground.errors import DefinitionError, UnknownTypeError
from pyros1.msgs import Message, Service, load_message, load_service


def test_import_and_load_give_one_class() -> None:
    from pyros1.msgs.geometry_msgs.msg import Twist, Vector3

    assert Twist is load_message("geometry_msgs/Twist")
    assert type(Twist().linear) is Vector3
    assert issubclass(Twist, Message)
    assert (Twist.__module__, Twist.__qualname__) == ("pyros1.msgs.geometry_msgs.msg", "Twist")


def test_g08_services() -> None:
    from pyros1.msgs.std_srvs.srv import SetBool, SetBoolRequest, SetBoolResponse

    assert issubclass(SetBool, Service)
    assert (SetBool._type, SetBool._md5sum) == ("std_srvs/SetBool", "09fb03525b03e7ea1fd3992bafd87e16")
    assert (SetBool._request_class, SetBool._response_class) == (SetBoolRequest, SetBoolResponse)
    assert SetBoolRequest._type == "std_srvs/SetBoolRequest"
    assert SetBoolResponse(True, "x").message == "x"
    assert load_service("std_srvs/SetBool") is SetBool


def test_star_import_and_dir() -> None:
    namespace: dict[str, Any] = {}
    module = importlib.import_module("pyros1.msgs.std_msgs.msg")
    assert {"Float64", "Header"} <= set(dir(module))
    for name in module.__all__:
        namespace[name] = getattr(module, name)
    assert namespace["String"] is load_message("std_msgs/String")
    assert set(dir(importlib.import_module("pyros1.msgs.std_srvs.srv"))) >= {"Empty", "EmptyRequest", "EmptyResponse"}


def test_what_does_not_exist() -> None:
    with pytest.raises(ImportError, match="Nope"):
        from pyros1.msgs.std_msgs.msg import Nope  # noqa: F401
    with pytest.raises(ModuleNotFoundError, match="no_such_package"):
        import pyros1.msgs.no_such_package.msg  # noqa: F401
    with pytest.raises(ModuleNotFoundError):
        importlib.import_module("pyros1.msgs.std_msgs.other")
    for name in ("std_msgs/Nope", "nope/Nope", "Nope", ""):
        for load in (load_message, load_service):
            with pytest.raises(UnknownTypeError):
                load(name)


@pytest.mark.parametrize(
    ("statement", "text"),
    [
        (
            "from pyros1.msgs.std_msgs.msg import Flot64",
            "[std_msgs/Flot64] is unknown (did you mean 'std_msgs/Float64'?)",
        ),
        ("from pyros1.msgs.std_msgs.msg import String, Flot64", "(did you mean 'std_msgs/Float64'?)"),
        ("from pyros1.msgs.std_srvs.srv import Emty", "(did you mean 'std_srvs/Empty'?)"),
        ("from pyros1.msgs.std_srvs.msg import Empty", "did you mean pyros1.msgs.std_srvs.srv.Empty?"),
        (
            "from pyros1.msgs.std_msg.msg import String",
            "no package [std_msg] with definitions (did you mean 'std_msgs'?)",
        ),
        ("import pyros1.msgs.std_msgs.msg.String", "write from pyros1.msgs.std_msgs.msg import String"),
    ],
)
def test_a_failing_import_says_what_was_meant(statement: str, text: str) -> None:
    with pytest.raises(ImportError) as caught:
        exec(statement, {})
    assert text in str(caught.value)


def test_one_finder_per_process() -> None:
    assert msgs_imports.finder() is msgs_imports.finder()
    assert sum(isinstance(each, msgs_imports.GeneratedModules) for each in sys.path_importer_cache.values()) == 1


def test_own_modules_are_all_known() -> None:
    folder = Path(pyros1.msgs.__file__).parent
    found = {path.stem for path in folder.glob("*.py") if not path.name.startswith("_")}
    assert found | {"definitions"} == msgs_imports.OWN_MODULES


@pytest.fixture
def finder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> MessageFinder:
    for package, text in (("base", "int8 a"), ("broken", "what")):
        folder = tmp_path / package
        (folder / "msg").mkdir(parents=True)
        (folder / "package.xml").write_text(f"<package><name>{package}</name></package>")
        (folder / "msg" / "A.msg").write_text(text)
    finder = MessageFinder({"ROS_PACKAGE_PATH": str(tmp_path)})
    monkeypatch.setattr(pyros1.msgs.__path__.modules, "message_finder", finder)
    yield finder
    for name in [name for name in sys.modules if name.startswith(("pyros1.msgs.base_", "pyros1.msgs.broken"))]:
        del sys.modules[name]


def test_a_ros_package_with_the_name_of_an_own_module(finder: MessageFinder) -> None:
    cls = finder.message("base/A")
    assert (cls._type, cls.__module__) == ("base/A", "pyros1.msgs.base_.msg")


def test_a_wrong_definition_says_where(finder: MessageFinder) -> None:
    with pytest.raises(DefinitionError, match=r"A\.msg:1: "):
        finder.message("broken/A")


def test_threads_get_one_class(finder: MessageFinder) -> None:
    barrier = threading.Barrier(8)
    classes = []

    def load() -> None:
        barrier.wait(5)
        classes.append(finder.message("base/A"))

    threads = [threading.Thread(target=load) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(5)
    assert len(classes) == 8 and len(set(classes)) == 1
