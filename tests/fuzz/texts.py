"""Fuzzers of what people and programs write: definitions, launch files, YAML, expressions, robots, manifests."""

from __future__ import annotations

import contextlib
import tempfile
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path
from typing import Any

import pyros1
from pyros1.finding.manifest import ManifestError, read_manifest
from pyros1.ground.errors import DefinitionError, InvalidNameError, LaunchError, MessageError, PackageNotFoundError
from pyros1.ground.expressions import ExpressionError
from pyros1.ground.names import parse_arguments, resolve_name
from pyros1.ground.timing import Time
from pyros1.launch.reading.expression import evaluate
from pyros1.launch.reading.loader import load_plan
from pyros1.launch.reading.resources import Resources
from pyros1.launch.reading.substitution import substitute
from pyros1.msgs import from_definition, load_message
from pyros1.msgs.fill import fill_message
from pyros1.msgs.json_form import to_json
from pyros1.msgs.spec import action_messages, parse_message, parse_service
from pyros1.msgs.text import format_message
from pyros1.observe.expression import Expression
from pyros1.reconfigure.values import parse_choices
from pyros1.urdf.model import UrdfError
from pyros1.urdf.reading import read_robot
from pyros1.values import YamlError, dump_yaml, load_all_yaml
from pyros1.values.angles import evaluate_angle

from ..msgs import codec
from . import bombs
from .fuzzer import MEGABYTE, Fuzzer, words


def _load(path: Path) -> Any:
    """Return a module that programs know under another name, without what they import beside it."""
    spec = spec_from_loader(path.stem, SourceFileLoader(path.stem, str(path)))
    assert spec is not None and spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


local_data = _load(Path(pyros1.__file__).parent / "drop_in" / "modules" / "smach_ros" / "local_data.py")

_KINDS = [
    "bool",
    "int8",
    "uint8",
    "int64",
    "float32",
    "string",
    "time",
    "duration",
    "char",
    "byte",
    "Header",
    "p/Q",
    "Q",
]
_LINES = [f"{kind}{array} x{number}\n".encode() for number, kind in enumerate(_KINDS) for array in ("", "[]", "[3]")]
_LINES += [
    b"=" * 80,
    b"\nMSG: p/Q\n",
    b"int8 A=1\n",
    b"string S= # x\n",
    b"---\n",
    b"[99999999]",
    b"#",
    b"float64 F=nan\n",
]
_LINES += [b"__class__", b"self", b"None", b"\xff", b"\0", b"std_msgs/Header", b"int8[", b"]", b"=", b"int32 X=0x10\n"]


def _text(data: bytes) -> str:
    return data.decode("utf-8", "surrogateescape")


def definitions(data: bytes) -> None:
    """Read text as a message, a service, an action and a full text."""
    text = _text(data)
    for read in (parse_message, parse_service, action_messages, from_definition):
        with contextlib.suppress(DefinitionError):
            read("p/T", text)


def messages(data: bytes) -> None:
    """Decode bytes by a definition from elsewhere: what comes out can be shown, filled in and encoded again."""
    definition, _, body = data.partition(b"\0")
    cls = from_definition("p/T", _text(definition))
    message = codec.decode(cls, body, 0, len(body))
    again = codec.encode(message)
    assert codec.encode(codec.decode(cls, again, 0, len(again))) == again
    assert codec.encode(codec.copy(message)) == again
    format_message(message)
    fill_message(cls(), to_json(message))


class _Packages:
    def find(self, name: str) -> Path:
        if name != "pkg":
            raise PackageNotFoundError(f"package [{name}] not found")
        return Path("/ws/pkg")

    def list(self) -> Any:
        return ["pkg", "other"]

    def find_resource(self, package: str, filename: str) -> Any:
        return []

    def find_executable(self, package: str, name: str) -> Any:
        return []

    def executables(self, package: str) -> Any:
        return []


def launch_file(data: bytes) -> None:
    """Read a launch file, which may include itself."""

    def read(path: str) -> bytes:
        if path in ("/d/a.launch", "/d/a.yaml"):
            return data
        raise FileNotFoundError(2, "No such file or directory", path)

    resources = Resources(_Packages(), {"HOME": "/home/me"}, read, lambda words: "5\n", lambda: "host-1.x:2")
    load_plan(["/d/a.launch"], {"x": "1"}, resources)


class _Source:
    def env(self, name: str) -> str:
        raise LaunchError("no")

    def optional_env(self, name: str, default: str) -> str:
        return default

    def find(self, package: str, path: str) -> str:
        return "/" + package + path

    def anon(self, identifier: str) -> str:
        return identifier + "1"

    def arg(self, name: str) -> str:
        return "17" if name == "x" else "$(arg x)"

    def dirname(self) -> str:
        return "/d"

    def args(self) -> dict[str, str]:
        return {"x": "17", "y": "[1, 2]"}


def substitution(data: bytes) -> None:
    """Replace substitutions."""
    result = substitute(_text(data), _Source())
    assert len(result) < 20 * len(data) + 1_000_000  # a list of 10,000 items, written out


_NAMES: dict[str, Any] = {"i": 7, "f": 2.5, "s": "abc", "l": [1, 2, 3], "m": load_message("std_msgs/Header")(seq=3)}


def expressions(data: bytes) -> None:
    """Evaluate text as a filter, as a substitution and as an angle."""
    text = _text(data)
    with contextlib.suppress(ExpressionError):
        Expression(text)(_NAMES)
    with contextlib.suppress(LaunchError):
        evaluate(text, _NAMES, {})
    with contextlib.suppress(ExpressionError, ValueError, OverflowError):
        evaluate_angle(text)


def _plain(value: Any) -> Any:
    """Return what can be compared of a value: keys may change their order, and NaN is not equal to itself.

    Tuples, of !!omap and !!pairs, are written as lists, as parameters are.
    """
    if isinstance(value, (list, tuple)):
        return [_plain(each) for each in value]
    if isinstance(value, dict):
        return sorted(((repr(key), _plain(each)) for key, each in value.items()), key=lambda pair: pair[0])
    return sorted(map(repr, value)) if isinstance(value, set) else repr(value)


def yaml(data: bytes) -> None:
    """Read values, write them and read them back; put them into a message."""
    for value in load_all_yaml(_text(data)):
        with contextlib.suppress(YamlError):
            text = dump_yaml(value)
            if len(text) < 20_000:  # a bomb of 200 bytes is a long text, which takes its time to read
                assert _plain(load_all_yaml(text)) == _plain([value])
        with contextlib.suppress(MessageError):
            fill_message(load_message("sensor_msgs/Imu")(), value, Time(1, 2), {})


def urdf(data: bytes) -> None:
    """Read a robot."""
    read_robot(_text(data))


def manifest(data: bytes) -> None:
    """Read the manifest of a package."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "package.xml")
        path.write_bytes(data)
        found = read_manifest(path)
        found.run_dependencies()
        found.exported_values("python", "path")


def names(data: bytes) -> None:
    """Read the words of a command line, and resolve them as names."""
    given = _text(data).split("\n")
    arguments = parse_arguments(given)
    for word in given:
        with contextlib.suppress(InvalidNameError):
            resolve_name(word, "/n", dict(list(arguments.remappings.items())[:3]))


def userdata(data: bytes) -> None:
    """Read what another state machine sends, which is a pickle; and the choices of a parameter, which are Python."""
    parse_choices(_text(data))
    local_data.decode(data.decode("latin-1"))


_XML = words(
    r"""
    <  >  />  </  <!--  -->  <![CDATA[  ]]>  &lt;  &#9;  encoding="latin-1"  <?a?>
    <!DOCTYPE a [<!ENTITY b "c">]>  &b;  xmlns:x='y'  <?xml version='1.0' encoding='x'?>  \0  \xff
    """
)
_LAUNCH = words(
    r"""
    <arg name='x' value='1'/>  <arg name='y' default='$(arg x)'/>  <include file='/d/a.launch'/>  </group>
    <param name='p' value='1' type='int'/>  <group ns='g'>  <node pkg='pkg' type='t' name='n'/>  $(find pkg)
    <rosparam>  </rosparam>  <rosparam command='load' file='/d/a.yaml'/>  <remap from='a' to='b'/>
    <env name='E' value='$(env HOME)'/>  <machine name='m' address='h'/>  if='$(eval x > 3)'  ns='/'
    <test pkg='pkg' type='t' test-name='n'/>  output='screen'  pass_all_args='true'  $(anon a)  '  "
    """
)
_SUBSTITUTIONS = words(
    r"""
    $(arg x)  $(find p)  $(env A)  $(optenv A b c)  $(anon a)  $(dirname)  $(eval\x20  )
    """
)
_EXPRESSIONS = words(
    r"""
    i  f  s  l  m  m.seq  (  )  [  ]  {  }  ,  :  .  +  -  *  /  //  %  **  <<  >>  &  |  ^  ~  <  ==  !=  in
    is  \x20not\x20  \x20and\x20  \x20or\x20  \x20if\x20  \x20else\x20  \x20for x in l  '%s'  '%999999999d'
    9999999999999999999999999999999999999999  1e308  sum(  range(9999)  str(  len(  abs(  round(  pow(  min(
    sorted(  set(  dict(  .format(  .join(  .replace(  'a'  __class__  lambda x:\x20  f'{i}'  :=  (yield)  pi
    """
)
_YAML = words(
    r"""
    :\x20  -\x20  \n  \x20\x20  [  ]  {  }  ,\x20  &a\x20  *a  <<: *a  !!binary\x20  !!set\x20  !!omap\x20
    !!python/object/apply:os.system\x20  !degrees 90  rad(2*pi)  deg(90)  1:2:3  0x1F  1e5  .inf  |\x20
    2001-01-01 00:00:00 +99  '  "  ---\n  %YAML 1.1\n  ?\x20  !!timestamp\x20  null  \\u0000  \xff
    """
)
_URDF = words(
    r"""
    <robot name='r'>  </robot>  <link name='a'/>  <link name='b'/>  <limit lower='-1' upper='1'/>  nan
    <joint name='j' type='revolute'><parent link='a'/><child link='b'/>  </joint>
    <origin xyz='1 2 3' rpy='0 0 0'/>  <mimic joint='j' multiplier='2'/>  <axis xyz='0 0 1'/>  1e999
    <joint name='k' type='fixed'>  'floating'
    """
)
_PACKAGE = words(
    r"""
    <package format='2'>  </package>  <name>p</name>  <depend>q</depend>  <export>  </export>
    <python path='${prefix}/src'/>  <version>1</version>  <rosdep name='x'/>  <metapackage/>
    """
)
_PICKLE = words(
    r"""
    \x80\x02}q\0  X\x01\0\0\0a  K\x01  s.  ]  (  u  e  t  \x85  \x86  2  0  q\x01  cos\nsystem\n
    c__builtin__\nset\n  R  h\0  b  \x81  j\xff\xff\xff\x7f  I1\n  L1L\n  .
    {'enum': [{'name': 'a', 'type': 'int', 'value': 1}]}  -  (  {  9999999999999999999999999999999999999999
    c_codecs\nencode\n  l
    """
)

_LINE = b"{'enum': [{'name': 'a', 'type': 'int', 'value': 1, 'description': ''}], 'enum_description': ''}"
_ROBOT = b"""<robot name='r'><link name='a'/><link name='b'/>
<joint name='j' type='revolute'><parent link='a'/><child link='b'/><origin xyz='1 2 3' rpy='0 0 0'/>
<axis xyz='0 0 1'/><limit lower='-1' upper='1'/></joint></robot>"""
_FULL = "int32 a\nstring[] b\ntime c\nQ[2] d\n" + "=" * 80 + "\nMSG: p/Q\nfloat64 x\nuint8[] y"
_BODY = codec.encode(from_definition("p/T", _FULL)(a=1, b=["x", "y"]))


def _levels(count: int) -> bytes:
    """Return a definition with so many types, each in the one before."""
    rule = "=" * 80
    types = "".join(f"{rule}\nMSG: p/L{number}\nL{number + 1} x\n" for number in range(count))
    return f"L0 x\n{types}{rule}\nMSG: p/L{count}\nint8 x\n".encode()


def _itself() -> bytes:
    """Return a definition of a type that contains itself by way of another one."""
    return f"Q x\n{'=' * 80}\nMSG: p/Q\nT x\n{'=' * 80}\nMSG: p/T\nQ x\n".encode()


def _launch_bombs() -> list[bytes]:
    found = bombs.entities(b"launch", b"<param name='p' value='%s'/>")
    found += [bombs.nested(b"<group>", b"</group>", before=b"<launch>", after=b"</launch>")]
    found += [b"<launch><rosparam>" + each + b"</rosparam></launch>" for each in bombs.yaml()[:2]]
    doubled = b"".join(b"<arg name='a%d' value='%s'/>" % (n, b"$(arg a%d)" % (n - 1) * 10) for n in range(1, 30))
    return [*found, b"<launch><arg name='a0' value='aaaaaaaaaa'/>" + doubled + b"</launch>"]


FUZZERS = {
    "definitions": Fuzzer(
        definitions,
        (),
        _LINES,
        lambda: [_FULL.encode(), b"int8 a\n---\nint8 b\n---\nint8 c\n", _levels(3000), _itself()],
    ),
    "messages": Fuzzer(messages, (MessageError,), [*_LINES, b"\0"], lambda: [_FULL.encode() + b"\0" + _BODY]),
    "launch_file": Fuzzer(
        launch_file,
        (LaunchError,),
        [*_XML, *_LAUNCH, *_YAML],
        lambda: [*(b"<launch>" + each + b"</launch>" for each in _LAUNCH), *_launch_bombs()],
        memory=64 * MEGABYTE,
    ),
    "substitution": Fuzzer(
        substitution,
        (LaunchError,),
        [*_SUBSTITUTIONS, *_EXPRESSIONS],
        lambda: [*(b"a " + each for each in _SUBSTITUTIONS), b"$(find p)" * 2000, b"$(arg x" * bombs.DEEP],
    ),
    "expressions": Fuzzer(
        expressions,
        (),
        _EXPRESSIONS,
        lambda: [
            b"i + 2 * f",
            b"[x for x in l if x > 1]",
            b"'%s' % s",
            b"m.seq == 3 and any(x for x in l)",
            b"-pi/2",
            *bombs.python(),
        ],
        memory=64 * MEGABYTE,
    ),
    "yaml": Fuzzer(
        yaml,
        (YamlError,),
        _YAML,
        lambda: [
            b"a: [1, 2.5, {b: c}]",
            b"- &a x\n- *a\n",
            b"header: {stamp: now}",
            b"x: !degrees 90\ny: rad(pi)",
            *bombs.yaml(),
        ],
        memory=64 * MEGABYTE,
    ),
    "urdf": Fuzzer(
        urdf,
        (UrdfError,),
        [*_XML, *_URDF],
        lambda: [_ROBOT, *bombs.entities(b"robot"), bombs.nested(b"<robot>", b"</robot>")],
    ),
    "manifest": Fuzzer(
        manifest,
        (ManifestError,),
        [*_XML, *_PACKAGE],
        lambda: [b"<package><name>p</name></package>", *bombs.entities(b"package"), bombs.nested(b"<a>", b"</a>")],
    ),
    "names": Fuzzer(
        names, (), [b"a:=b", b"~c", b"/", b"__ns:=", b"_p:=[1]", b"\n", b"__name:=x", b":="], lambda: [b"a:=b\na\n~a"]
    ),
    "userdata": Fuzzer(
        userdata,
        (ValueError,),
        _PICKLE,
        lambda: [
            _LINE,
            local_data.encode({"a": [1, {"b"}]}).encode(),
            *bombs.python(),
            b"\x80\x02})" + b"\x85" * 10**5,
        ],
    ),
}
