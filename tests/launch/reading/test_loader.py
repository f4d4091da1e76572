# ruff: noqa: E501 - tables and programs in one line
"""Launch files to plans: scopes, arguments, includes, parameters, nodes."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest

from pyros1.ground.errors import LaunchError, PackageNotFoundError
from pyros1.launch.plan import ExitPolicy, Plan
from pyros1.launch.reading.loader import load_plan
from pyros1.launch.reading.resources import Resources


class FakePackages:
    def find(self, name: str) -> Path:
        if name != "pkg":
            raise PackageNotFoundError(f"package [{name}] not found")
        return Path("/ws/pkg")

    def list(self) -> Any:
        return ["pkg", "other"]

    def find_resource(self, package: str, filename: str) -> list[Path]:
        return []

    def executables(self, package: str) -> list[str]:
        return []

    def find_executable(self, package: str, name: str) -> list[Path]:
        return []


def load(text: str, files: dict[str, Any] | None = None, **args: str) -> Plan:
    contents = {"/d/main.launch": text, **(files or {})}

    def read(path: str) -> bytes:
        if path not in contents:
            raise FileNotFoundError(2, "No such file or directory", path)
        value = contents[path]
        return value if isinstance(value, bytes) else str(value).encode()

    commands = {("echo", "5"): "5\n", ("echo", "a b"): "a b\n"}
    resources = Resources(
        FakePackages(), {"HOME": "/home/me"}, read, lambda words: commands[tuple(words)], lambda: "host-1.x:2"
    )
    return load_plan(["/d/main.launch"], args, resources)


def params(text: str, files: dict[str, Any] | None = None, **args: str) -> dict[str, Any]:
    return load(f"<launch>{text}</launch>", files, **args).params


def refuse(text: str, message: str, files: dict[str, Any] | None = None) -> None:
    with pytest.raises(LaunchError, match=message):
        load(f"<launch>\n{text}\n</launch>", files)


def test_includes_that_go_in_a_circle_are_told_once() -> None:
    files = {
        "/d/a": '<launch>\n<include file="/d/b"/>\n<include file="/d/b"/></launch>',
        "/d/b": '<launch><include file="/d/a"/></launch>',
    }
    refuse(
        '<include file="/d/a"/>',
        r"^/d/\w:\d: includes are nested more than 100 deep(.*\n){2}  included at /d/\w:\d \(repeatedly\)\n  included at /d/main.launch:2$",
        files,
    )
    main = {"/d/main.launch": '<launch>\n<include file="/d/a"/></launch>', **files}
    problems: list[LaunchError] = []
    load_plan(
        ["/d/main.launch"], {}, Resources(FakePackages(), {}, lambda path: main[path].encode()), problems=problems
    )
    assert len(problems) == 1, "and the search for more of them ends"


def test_args_are_lazy_overridable_and_scoped_x57_x58_x60() -> None:
    text = '<arg name="r"/><arg name="d" default="1"/><group><arg name="g" value="2"/></group><param name="p" value="$(arg d)"/>'
    assert params(text) == {"/p": 1}
    assert params(text, d="7", unknown="x") == {"/p": 7}
    refuse(
        '<arg name="r"/><param name="p" value="$(arg r)"/>',
        r"main\.launch:2: .*\[/d/main.launch\] requires the 'r' arg to be set",
    )
    refuse('<group><arg name="g" value="2"/></group><param name="p" value="$(arg g)"/>', "requires the 'g' arg")
    refuse('<arg name="a" default="1"/><arg name="a"/>', "already been declared")
    declared = load(f'<launch>{text}<arg name="fixed" value="3"/></launch>', r="0").args
    assert [(arg.name, arg.default) for arg in declared.values()] == [("r", None), ("d", "1")], "those one can give"
    with pytest.raises(LaunchError, match="cannot override arg 'v'"):
        load('<launch><arg name="v" value="1"/></launch>', v="2")


def test_files_are_one_plan_and_each_gets_the_arguments_x02_x03() -> None:
    text = b'<launch><arg name="v" default="none"/><param name="%b" value="$(arg v)"/><param name="last" value="%b"/></launch>'
    files = {"/d/a.launch": text % (b"a", b"a"), "/d/b.launch": text % (b"b", b"b")}
    resources = Resources(FakePackages(), {}, files.__getitem__, read_stdin=lambda: text % (b"s", b"s"))
    plan = load_plan(["/d/a.launch", "-", "/d/b.launch"], {"v": "7"}, resources)
    assert plan.params == {"/a": 7, "/s": 7, "/b": 7, "/last": "b"}
    assert plan.files == ["/d/a.launch", "<stdin>", "/d/b.launch"]


INCLUDED = {
    "/d/i.launch": '<launch><arg name="d" default="z"/><param name="d" value="$(arg d)"/><node pkg="pkg" type="t" name="n"/></launch>'
}


def test_includes_x59() -> None:
    include = '<include file="$(dirname)/i.launch" ns="a"'
    assert params(f"{include}/>", INCLUDED) == {"/a/d": "z"}
    assert not load(f"<launch>{include}/></launch>", INCLUDED).args, "only those of the file itself can be given"
    assert params(f'{include}><arg name="d" value="1"/></include>', INCLUDED) == {"/a/d": 1}
    assert params(f'<arg name="d" value="o"/>{include} pass_all_args="true"/>', INCLUDED) == {"/a/d": "o"}
    refuse(
        f'{include}><arg name="zz" value="1"/></include>',
        r"unused args \[zz\] for include of \[/d/i.launch\]",
        INCLUDED,
    )
    refuse('<include file="/d/no.launch"/>', r"main\.launch:2: cannot read \[/d/no.launch\]")
    refuse("<include/>", "missing required attribute: 'file'")
    loop = {"/d/l.launch": '<launch><include file="/d/l.launch"/></launch>'}
    refuse('<include file="/d/l.launch"/>', "include itself", loop)


def test_conditions_x55() -> None:
    assert params(
        '<param name="a" value="1" if="TRUE"/><param name="b" value="1" unless="1"/><group if="0"><bogus/></group>'
    ) == {"/a": 1}
    refuse('<param name="a" value="1" if="1" unless="1"/>', "cannot set both 'if' and 'unless'")
    refuse('<param name="a" value="1" if="maybe"/>', "maybe is not a 'bool' type")


def test_scopes_of_nodes_x61_x62_x65_x67_x68() -> None:
    plan = load(
        """<launch>
        <param name="~p" value="1"/><env name="E" value="o"/><remap from="c" to="t"/>
        <group ns="a"><remap from="c" to="h"/><remap from="x" to="y"/>
          <node pkg="pkg" type="t" name="n" ns="b" args="'one word' two" launch-prefix="nice -n 5" respawn="true" respawn_delay="2" output="screen">
            <env name="E" value="own"/><remap from="c" to="l"/><param name="q" value="2"/><param name="/g" value="3"/>
          </node></group>
        <node pkg="pkg" type="t" name="m" ns="/z" required="true" clear_params="true" cwd="node"/></launch>"""
    )
    first, second = plan.nodes
    assert (first.full_name, first.namespace, first.args, first.prefix) == (
        "/a/b/n",
        "/a/b/",
        ["one word", "two"],
        ["nice", "-n", "5"],
    )
    assert first.remappings == [("x", "y"), ("c", "l")]
    assert (first.env, first.output, first.exit_policy) == ({"E": "own"}, "screen", ExitPolicy(True, 2.0))
    assert (second.full_name, second.remappings, second.env, second.exit_policy.required, second.cwd) == (
        "/z/m",
        [("c", "t")],
        {"E": "o"},
        True,
        "node",
    )
    assert plan.params == {"/a/b/n/p": 1, "/a/b/n/q": 2, "/a/b/n/g": 3, "/z/m/p": 1}
    assert plan.clear_params == ["/z/m/"]
    assert plan.find_node("z/m") is second
    assert plan.find_node("nope") is None


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('<node pkg="p" type="t"/>', "missing required attribute: 'name'"), ('<node pkg="" type="t" name="n"/>', "package must be non-empty"),
        ('<node pkg="p" type="t" name="a/b"/>', "cannot contain a namespace"), ('<node pkg="p" type="t" name=""/>', "name must be non-empty"),
        ('<node pkg="p" type="t" name="n" respawn="true" required="true"/>', "respawn and required"), ('<node pkg="p" type="t" name="n" output="x"/>', "output must be"),
        ('<node pkg="p" type="t" name="n" cwd="x"/>', "cwd must be"), ('<node pkg="p" type="t" name="n" respawn="x"/>', "respawn"),
        ('<node pkg="p" type="t" name="n" args="\'"/>', "cannot split"), ('<group ns=""/>', "empty 'ns'"), ('<group clear_params="true"/>', "'ns' attribute must be set"),
        ('<remap from="a"/>', "from/to"), ('<env name="a"/>', "name/value"), ('<machine name="a"/>', "'address'"), ('<param name="a"/>', "one and only one"),
        ('<test pkg="p" type="t" test-name="n" output="log"/>', "cannot have 'output'"), ('<rosparam>5</rosparam>', "'param' attribute must be set"),
        ('<rosparam>a: [1</rosparam>', r"main\.launch:2: error loading <rosparam>"), ('<rosparam command="x"/>', "command must be"),
        ('<param name="a" value="$(foo b)"/>', r"Unknown substitution command \[foo b\]"), ('<param name="a" value="$(arg $(arg b))"/>', "Dollar signs"),
        ('<param name="" value="1"/>', "has an empty 'name'"), ('<group ns="/"><param name=" " value="1"/></group>', "has an empty 'name'"),
        ('<param name="a" value="$(env NOPE)"/>', "'NOPE' is not set"), ('<param name="a" value="$(find nope)"/>', r"\[nope\] not found"),
    ],
)  # fmt: skip
def test_errors_name_file_and_line(text: str, message: str) -> None:
    refuse(text, message)
    with pytest.raises(LaunchError, match=r"^/d/main\.launch:2: "):
        load(f"<launch>\n{text}\n</launch>")


def test_duplicate_nodes_x63() -> None:
    node = '<node pkg="p" type="t" name="n"/>'
    refuse(node + "\n" + node, r"main.launch:3: roslaunch file contains multiple nodes named \[/n\]")


def test_substitutions_x70_x72_x73() -> None:
    assert params('<param name="a" value="$(find pkg)/x $(optenv NOPE a  b)|$(env HOME) $5 $(arg"/>') == {
        "/a": "/ws/pkg/x a b|/home/me $5 $(arg"
    }
    assert params('<arg name="f" value="q"/><param name="a" value="$(find pkg)/$(arg f)"/>') == {"/a": "/ws/pkg/q"}
    assert params('<arg name="i" value="2"/><param name="a" value="$(eval i * 2 == 4)"/>') == {"/a": True}
    anonymous = params('<param name="a" value="$(anon x) $(anon x) $(anon y)"/>')["/a"]
    assert anonymous == "x_host_1_x_2 x_host_1_x_2 y_host_1_x_2"


def test_parameter_sources_x37_x40_x75() -> None:
    files = {"/d/t.txt": "text\n", "/d/b.bin": b"\x00\xff"}
    text = '<param name="t" textfile="$(dirname)/t.txt"/><param name="b" binfile="/d/b.bin"/><param name="c" command="echo 5"/>'
    text += """<param name="e" command="echo 'a b'"/>"""
    assert params(text, files) == {"/t": "text\n", "/b": b"\x00\xff", "/c": 5, "/e": "a b\n"}


def test_rosparam_x66_x76() -> None:
    files = {"/d/p.yaml": "a: {b: {c: 1}, empty: {}}\nh: $(env HOME)\nd: deg(180)"}
    loaded = params(
        '<rosparam file="/d/p.yaml" ns="n" subst_value="true"/><rosparam param="l">[1, yes]</rosparam><rosparam/>',
        files,
    )
    assert loaded == {"/n/a/b/c": 1, "/n/h": "/home/me", "/n/d": pytest.approx(3.14159265), "/l": [1, True]}
    plan = load(
        '<launch><param name="a" value="1"/><param name="a/b" value="2"/><rosparam command="delete" param="x"/></launch>'
    )
    assert plan.warnings == ["parameter [/a/b] conflicts with parent parameter [/a]"]
    assert [(action.command, action.name) for action in plan.actions] == [("delete", "/x")]
    refuse('<rosparam file="/d/no.yaml"/>', r"cannot read \[/d/no.yaml\]")
    refuse(
        '<group ns="g"><rosparam ns="/">[1]</rosparam></group>',
        "only a dictionary can be loaded into the namespace '/'",
    )


def test_unknown_tags_and_attributes_only_warn_x56() -> None:
    plan = load('<launch deprecated="old"><parm/><node pkg="p" type="t" name="n" respwan="1"/><master/></launch>')
    assert len(plan.nodes) == 1
    assert plan.warnings == [
        "[/d/main.launch] DEPRECATED: old",
        "[/d/main.launch:1] unrecognized tag parm (did you mean 'param'?)",
        "[/d/main.launch:1] unknown <node> attribute 'respwan' (did you mean 'respawn'?)",
        "ignoring defunct <master /> tag",
    ]


def test_a_schema_for_editors_is_no_unknown_attribute() -> None:
    schema = 'xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:noNamespaceSchemaLocation="a.xsd"'
    assert load(f"<launch {schema}/>").warnings == []
    assert load(f'<launch {schema} depricated="x"><group xsi:x="1"/></launch>').warnings == [
        "[/d/main.launch:1] unknown <launch> attribute 'depricated' (did you mean 'deprecated'?)",
        "[/d/main.launch:1] unknown <group> attribute 'xsi:x'",
    ]


def test_what_a_group_waits_for_its_nodes_wait_for() -> None:
    plan = load(
        """<launch>
        <group ns="g" wait-for="topic:/scan param:~ready" wait-timeout="5">
            <node pkg="pkg" type="t" name="a"/>
            <group wait-for="node:other" wait-timeout="0">
                <node pkg="pkg" type="t" name="b" wait-for="service:/s topic:/scan"/>
            </group>
            <node pkg="pkg" type="t" name="c" wait-timeout="7"/>
        </group>
        <node pkg="pkg" type="t" name="d"/>
        </launch>"""
    )
    waits = {node.name: ([str(each) for each in node.wait_for], node.wait_timeout) for node in plan.nodes}
    assert waits == {
        "a": (["topic:/scan", "param:/g/a/ready"], 5.0),
        "b": (["topic:/scan", "param:/g/b/ready", "node:/g/other", "service:/s"], 0.0),
        "c": (["topic:/scan", "param:/g/c/ready"], 7.0),
        "d": ([], 60.0),
    }


@pytest.mark.parametrize("name", ["/dev/null", "folder", "pipe"])
def test_rosparam_loads_regular_files_only(tmp_path: Path, name: str) -> None:
    (tmp_path / "folder").mkdir()
    os.mkfifo(tmp_path / "pipe")
    resources = Resources(FakePackages(), {})
    (tmp_path / "main.launch").write_text(f'<launch><rosparam command="load" file="{tmp_path / name}"/></launch>')
    with pytest.raises(LaunchError, match=r"error loading <rosparam> tag: cannot read .* it is not a regular file"):
        load_plan([str(tmp_path / "main.launch")], {}, resources)


def test_real_time_priorities() -> None:
    nodes = "".join(
        f'<node pkg="p" type="t" name="{name}" {words}/>'
        for name, words in (("a", 'priority="50"'), ("b", 'priority=""'), ("c", ""))
    )
    assert [node.priority for node in load(f"<launch>{nodes}</launch>").nodes] == [50, 0, 0]
