"""The import hook: messages of packages of every origin, modules of packages, and names that we lack."""

from __future__ import annotations

from pathlib import Path

import pytest
from programs import START, run

from pyros1.drop_in.unsupported import REASONS

MANIFEST = "<package format='2'><name>{}</name><version>0.1.0</version></package>"


def package(root: Path, name: str, **files: str) -> Path:
    """Make a package; the keys are paths with ``__`` for slashes and dots at the end as ``_``."""
    folder = root / name
    folder.mkdir(parents=True)
    (folder / "package.xml").write_text(MANIFEST.format(name))
    for path, text in files.items():
        file = folder / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
    return folder


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """A folder of ROS_PACKAGE_PATH."""
    folder = tmp_path / "src"
    folder.mkdir()
    return folder


def output(path: Path, text: str, **environ: str) -> str:
    return run(text, {"ROS_PACKAGE_PATH": str(path), **environ})


def test_messages_services_and_actions_of_a_folder(path: Path) -> None:
    files = {"msg/A.msg": "int32 x\nB[] bs", "msg/B.msg": "string s", "srv/C.srv": "A a\n---\nbool ok"}
    package(path, "mine_msgs", **files, **{"action/Do.action": "int32 goal\n---\nint32 result\n---\nint32 now"})
    said = output(
        path,
        "import mine_msgs.msg, mine_msgs.srv, genpy\n"
        "from mine_msgs.msg import *\n"
        f"from mine_msgs.msg.{'_A'} import A as again\n"  # stock's generator makes such modules
        f"from mine_msgs.srv.{'_C'} import C, CRequest, CResponse\n"
        "print(A(1, [B('q')]) == again(1, [B('q')]), isinstance(B(), genpy.Message), A._type)\n"
        "print(C._request_class is CRequest is mine_msgs.srv.CRequest, CRequest().a.x, CResponse().ok)\n"
        "print(DoActionGoal().goal.goal, DoResult().result, DoAction()._slot_types)\n",
    )
    assert said.splitlines() == [
        "True True mine_msgs/A",
        "True 0 False",
        "0 0 ['mine_msgs/DoActionGoal', 'mine_msgs/DoActionResult', 'mine_msgs/DoActionFeedback']",
    ]


STAR = """
from robot_api.{kind} import *
names = sorted(name for name in globals() if name[0] != "_")
print(*names)
print(codecs.__name__, sys.__name__, struct.__name__, genpy.Time.__name__, python3, std_msgs.msg.String()._type)
print(robot_api.msg.Part()._type, geometry_msgs.msg.Point()._type)
"""


def test_names_that_stocks_generated_modules_bring(path: Path) -> None:
    files = {"msg/Part.msg": "geometry_msgs/Pose pose", "msg/Whole.msg": "Header header\nPart[] parts\ntime stamp"}
    package(path, "robot_api", **files, **{"srv/Get.srv": "string name\n---\nWhole whole"})
    modules = ["codecs", "genpy", "geometry_msgs", "python3", "robot_api", "std_msgs", "struct", "sys"]
    rest = ["codecs sys struct Time True std_msgs/String", "robot_api/Part geometry_msgs/Point"]
    for kind, classes in (("msg", ["Part", "Whole"]), ("srv", ["Get", "GetRequest", "GetResponse"])):
        said = output(path, STAR.format(kind=kind)).splitlines()
        assert said == [" ".join(sorted([*classes, *modules])), *rest]
    said = output(
        path,
        "import robot_api.msg, robot_api.srv\n"
        "print(sorted(name for name in vars(robot_api.msg) if isinstance(getattr(robot_api.msg, name), type)))\n"
        "print(robot_api.msg._Part.Part is robot_api.msg.Part, hasattr(robot_api.msg._Part, 'Whole'))\n"
        "from robot_api.msg._Part import *\n"
        "print('Whole' in globals(), 'std_msgs' in globals(), geometry_msgs.msg.Point().x)\n"
        "print([name for name in dir(robot_api.srv) if name[:2] != '__'])\n",
    )
    assert said.splitlines() == [
        "['Part', 'Whole']",
        "True False",
        "False False 0.0",
        str(sorted(["Get", "GetRequest", "GetResponse", "_Get", *modules])),
    ]


def test_a_definition_that_is_wrong_does_not_hide_the_others(path: Path) -> None:
    package(path, "robot_api", **{"msg/Good.msg": "Header header", "msg/Wrong.msg": "int32 int32 int32"})
    said = output(
        path,
        "import robot_api.msg\n"
        "print('Good' in dir(robot_api.msg), robot_api.msg.Good()._type, robot_api.msg.std_msgs.__name__)\n"
        "try:\n"
        "    from robot_api.msg import *\n"
        "except Exception as error:\n"
        "    print(type(error).__name__, 'Wrong.msg' in str(error))\n",
    )
    assert said.splitlines() == ["True robot_api/Good std_msgs", "DefinitionError True"]


def test_a_package_with_messages_and_a_module(path: Path) -> None:
    package(path, "robot", **{"msg/A.msg": "int32 x", "src/robot/__init__.py": "name = 3", "src/robot/b.py": "b = 4"})
    assert (
        output(path, "import robot, robot.b\nfrom robot.msg import A\nprint(robot.name, robot.b.b, A(5).x)")
        == "3 4 5\n"
    )


def test_modules_in_other_folders_and_of_other_names(path: Path) -> None:
    setup = "from catkin_pkg.python_setup import generate_distutils_setup\nd = generate_distutils_setup({})"
    package(
        path,
        "one",
        **{"setup.py": setup.format("packages=['one'], package_dir={'': 'lib/py'}"), "lib/py/one/__init__.py": "x = 1"},
    )
    package(
        path,
        "two",
        **{"setup.py": setup.format("**{'package_dir': {'other': 'nodes/other'}}"), "nodes/other/__init__.py": "x = 2"},
    )
    package(path, "three", **{"src/third.py": "x = 3", "setup.py": "this is no Python"})
    assert output(path, "import one, other, third; print(one.x, other.x, third.x)") == "1 2 3\n"


def test_folders_of_a_workspace_do_not_hide_messages(path: Path) -> None:
    for name in ("std_msgs/msg", "rospy", "plain"):
        (path / name).mkdir(parents=True)
    text = "import sys; sys.path.insert(0, sys.argv[1])\nimport rospy, std_msgs.msg, plain\n"
    assert run(text + "print(rospy.Time, std_msgs.msg.String('a').data, plain.__path__)", {}, str(path)).endswith(
        f"a _NamespacePath(['{path}/plain'])\n"
    )


def test_what_can_be_imported_otherwise_wins(path: Path, tmp_path: Path) -> None:
    package(path, "robot_msgs", **{"msg/A.msg": "int32 x"})
    other = tmp_path / "robot_msgs"
    other.mkdir()
    (other / "__init__.py").write_text("mine = True")
    text = "import sys; sys.path.insert(0, sys.argv[1])\nimport robot_msgs; print(robot_msgs.mine)"
    assert run(text, {"ROS_PACKAGE_PATH": str(path)}, str(tmp_path)) == "True\n"


REAL = "import sys; sys.path.insert(0, sys.argv[1])\n"
ASK = """
try:
    import std_msgs.msg
except ImportError as error:
    print(error.name)
import rospy; print(getattr(rospy, "real", "ours"))
"""


@pytest.mark.parametrize(
    ("wanted", "said"), [("", "std_msgs\nTrue\n"), ("stock", "std_msgs\nTrue\n"), ("pyros1", "ours\n")]
)
def test_a_real_rospy_wins_unless_ours_is_wanted(tmp_path: Path, wanted: str, said: str) -> None:
    (tmp_path / "rospy.py").write_text("real = True")
    assert run(REAL + ASK, {"PYROS1_ROSPY": wanted}, str(tmp_path)) == said


def test_stock_is_wanted_but_not_there() -> None:
    assert "No module named 'rospy'" in run("import rospy", {"PYROS1_ROSPY": "stock"}, code=1)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("import rospy.no", "ModuleNotFoundError: pyros1 has no rospy.no"),
        ("from genpy import no", "ModuleNotFoundError: pyros1 has no genpy.no"),
        ("import genpy; genpy.no", "AttributeError: pyros1 has no genpy.no"),
        ("import genpy.generator as g; g.msg_generator", "no modules are generated"),
        ("from std_msgs.msg import Strin", "did you mean 'std_msgs/String'?"),
        ("import stdd_msgs.msg", "did you mean 'std_msgs'?"),
        ("import std_msgs.no", "No module named 'std_msgs.no'"),
        (f"import std_msgs.msg.{'_No'}", "No module named 'std_msgs.msg._No'"),
        ("import nothing_here", "No module named 'nothing_here'"),
    ],
)
def test_names_that_are_not_there(text: str, said: str) -> None:
    assert said in run(text, {}, code=1)


def test_a_program_may_ask_whether_what_is_left_out_is_there(path: Path) -> None:
    """Only an import raises, with a reason: who asks gets None, as for every module that is nowhere."""
    text = "import importlib.util as u\nprint(u.find_spec('rqt_gui'), u.find_spec('rosmaster'), u.find_spec('nowhere'))"
    assert output(path, f"{text}\ntry:\n    import rosmaster\nexcept ImportError as e:\n    print(e)").splitlines() == [
        "None None None",
        f"No module named 'rosmaster': it is not part of pyros1: {REASONS['rosmaster']}",
    ]


def test_all_that_is_left_out_says_why() -> None:
    """Each row is met: none is of a package that can be imported, since its messages are there."""
    text = (
        "import importlib, sys\nfor name in sys.argv[1:]:\n    try:\n        importlib.import_module(name)\n"
        "        print(name)\n    except ImportError as error:\n        print(error)"
    )
    lines = run(text, {}, *REASONS).splitlines()
    assert len(lines) == len(REASONS)
    for line, (name, reason) in zip(lines, REASONS.items(), strict=True):
        # A package of Debian, such as rviz, has messages, too.
        assert line.endswith(reason) or (line == name and Path("/usr/share", name, "package.xml").exists())


def test_two_threads_import_at_once(path: Path) -> None:
    for name in "abcdefgh":
        package(path, f"{name}_msgs", **{"msg/A.msg": "int32 x"})
    text = (
        "import threading, importlib\nfound = []\n"
        "def load(n):\n    gate.wait(20)\n    found.append(importlib.import_module(n + '_msgs.msg').A._type)\n"
        "gate = threading.Barrier(8)\nthreads = [threading.Thread(target=load, args=[n]) for n in 'abcdefgh']\n"
        "[t.start() for t in threads]; [t.join(20) for t in threads]; print(len(found))"
    )
    assert output(path, text) == "8\n"


def test_there_is_a_finder_at_every_moment(path: Path) -> None:
    """Another thread may be looking for a module while the real finder replaces its placeholder."""
    package(path, "a_msgs", **{"msg/A.msg": "int32 x"})
    text = (
        "import sys, pyros1.drop_in.finder as finder\ninstall = finder.install\n"
        "ours = ('PlaceholderFinder', 'Finder')\n"
        "def show():\n    print(*(name for each in sys.meta_path if (name := type(each).__name__) in ours))\n"
        "def seen():\n    show()\n    installed = install()\n    show()\n    return installed\n"
        "finder.install = seen\nimport a_msgs.msg\nshow()"
    )
    assert output(path, text).splitlines() == ["PlaceholderFinder", "PlaceholderFinder Finder", "Finder"]


GENERATED = """
import codecs, genpy, struct
import std_msgs.msg
class Old(genpy.Message):
    _md5sum = "0"
    _type = "old/Old"
    _has_header = True
    _full_text = "Header header\\nint16[] values"
    __slots__ = ["header", "values"]
    _slot_types = ["std_msgs/Header", "int16[]"]
    def __init__(self, *args, **kwds):
        if args or kwds:
            super(Old, self).__init__(*args, **kwds)
            if self.header is None:
                self.header = std_msgs.msg.Header()
            if self.values is None:
                self.values = []
        else:
            self.header = std_msgs.msg.Header()
            self.values = []
    def _get_types(self):
        return self._slot_types
    def deserialize(self, str):
        try:
            return genpy.struct_I.unpack(str)
        except struct.error as e:
            raise genpy.DeserializationError(e)
"""
USER = """
import sys; sys.path.insert(0, sys.argv[1])
import io, copy, pickle, genpy, roslib.message
from old.msg import Old
from std_msgs.msg import Header
message = Old(Header(frame_id="map"), [1, 2])
buffer = io.BytesIO()
genpy.Message.serialize(message, buffer)
print(buffer.getvalue())
print(genpy.Message.deserialize(Old(), buffer.getvalue()) == message == copy.deepcopy(message))
print(pickle.loads(pickle.dumps(message)) == message, Old(values=[3]).header.frame_id == "", Old().values)
print(roslib.message.get_message_class("old/Old") is Old)
try:
    Old().deserialize(b"abc")
except genpy.DeserializationError as error:
    print(error)
"""


def test_modules_that_genpy_generated(tmp_path: Path) -> None:
    (tmp_path / "old" / "msg").mkdir(parents=True)
    for name, text in (("__init__", ""), ("msg/__init__", f"from .{'_Old'} import *"), ("msg/_Old", GENERATED)):
        (tmp_path / "old" / f"{name}.py").write_text(text)
    assert run(USER, {}, str(tmp_path)).splitlines() == [
        repr(b"\0" * 12 + b"\3\0\0\0map\2\0\0\0\1\0\2\0"),
        "True",
        "True True []",
        "True",
        "unpack requires a buffer of 4 bytes",
    ]


def test_the_start_folder_hides_no_other_sitecustomize(tmp_path: Path) -> None:
    (tmp_path / "sitecustomize.py").write_text("import sys; sys.mine = True")
    assert run("import sys, std_msgs.msg; print(sys.mine)", {"PYTHONPATH": f"{START}:{tmp_path}"}) == "True\n"


@pytest.mark.slow
def test_the_messages_of_an_imported_package_are_there(path: Path) -> None:
    text = "import rospy, {0}; print({0}.{1}.__name__, {0}.__name__)"
    for name in ("std_msgs.msg.Header", "diagnostic_msgs.msg.KeyValue", "std_srvs.srv.Empty", "sensor_msgs.msg.Imu"):
        top, _, rest = name.partition(".")
        assert output(path, text.format(top, rest)).split() == [name.rpartition(".")[2], top]
    assert output(path, "import rospy, std_msgs; print(hasattr(std_msgs, 'srv_'), hasattr(std_msgs, 'cfg'))") == (
        "False False\n"
    )


@pytest.mark.slow
def test_modules_that_stocks_import_by_themselves(path: Path) -> None:
    """Programs name them without an import of their own."""
    said = output(
        path,
        "import dynamic_reconfigure.server, genpy, rosbag, rosgraph, rospy, rosunit\n"
        "print(genpy.dynamic.generate_dynamic, rosgraph.xmlrpc.XmlRpcNode, rosgraph.roslogging.configure_logging)\n"
        "print(rosbag.migration, rosunit.baretest, dynamic_reconfigure.encoding, rospy.impl.rosout)\n"
        "for module in (rosbag, rosgraph, rospy.impl, dynamic_reconfigure, rosunit):\n"
        "    try: module.nope\n"
        "    except AttributeError as error: print(error)\n",
    )
    assert said.splitlines()[2:] == [
        f"pyros1 has no {name}.nope" for name in ("rosbag", "rosgraph", "rospy.impl", "dynamic_reconfigure", "rosunit")
    ]
