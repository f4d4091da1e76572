"""What launch files may not say, and how that is told."""

from __future__ import annotations

import pytest

from pyros1.finding.packages import PackageIndex
from pyros1.ground.errors import LaunchError
from pyros1.launch.plan import Plan
from pyros1.launch.reading.loader import load_plan
from pyros1.launch.reading.resources import Resources


def run_command(words: list[str]) -> str:
    raise LaunchError(f"{words[0]} has failed")


def load(text: str, **files: str) -> Plan:
    contents = {"main.launch": f"<launch>\n{text}\n</launch>", **files}

    def read(path: str) -> bytes:
        if path not in contents:
            raise FileNotFoundError(2, "No such file or directory", path)
        return contents[path].encode()

    resources = Resources(PackageIndex({}), {}, read, run_command, lambda: "host")
    return load_plan(["main.launch"], {}, resources)


TEST = '<test pkg="p" type="t" test-name="it"'
NODE = '<node pkg="p" type="t" name="n"'
NODES = [
    ('<test pkg="p" type="t"/>', "<test> tag is missing required attribute: 'test-name'"),
    ('<test pkg="p" type="t" name="n" test-name=" "/>', "'test-name' must be non-empty"),
    (f'{TEST} output="screen"/>', "<test> tags cannot have 'output' attribute"),
    (f'{TEST} time-limit="0"/>', "'time-limit' must be a positive number"),
    (f'{TEST} time-limit="long"/>', "time-limit"),
    (f'{TEST} retry="often"/>', "'retry' must be a whole number, not 'often'"),
    ('<node pkg="p" type="t"/>', "<node> tag is missing required attribute: 'name'"),
    ('<node pkg="p" type="t" name="a/b"/>', "node name cannot contain a namespace."),
    ('<node pkg="p" type="t" name=""/>', "name must be non-empty"),
    (f'{NODE} ns=""/>', "<node> tag has an empty 'ns' attribute"),
    ('<node pkg=" " type="t" name="n"/>', "package must be non-empty."),
    ('<node pkg="p" type=" " name="n"/>', "type must be non-empty."),
    (f'{NODE} output="both"/>', "output must be one of 'log', 'screen'."),
    (f'{NODE} cwd="/"/>', "cwd must be one of"),
    (f'{NODE} priority="100"/>', "priority must be a whole number from 0 (none) to 99, not '100'"),
    (f'{TEST} priority="50"/>', "<test> tags cannot have 'priority' attribute"),
    (f'{NODE} respawn_delay="soon"/>', "invalid float value for respawn_delay: soon"),
    (f"""{NODE} args="it's"/>""", "cannot split the 'args' attribute into arguments: No closing quotation in"),
    (f'{NODE} launch-prefix="nice \'"/>', "cannot split the 'launch-prefix' attribute into arguments"),
]
PARAMS = [
    ('<param value="1"/>', "<param> tag is missing required attribute: 'name'"),
    ('<param name=" " value="1"/>', "<param> tag has an empty 'name': a single value cannot replace all parameters"),
    ('<param name="a"/>', "<param> tag must have one and only one of value/textfile/binfile."),
    ('<param name="a" value="x" type="int"/>', "Invalid <param> tag: "),
    ('<param name="a" value="x" type="bool"/>', "Invalid <param> tag: x is not a 'bool' type"),
    ('<param name="a" value="[" type="yaml"/>', "Invalid <param> tag: cannot convert to type [yaml]: "),
    ('<param name="a" value="x" type="list"/>', "Invalid <param> tag: Unknown type 'list'"),
    ('<param name="a" binfile="nothing"/>', r"cannot read [nothing]: No such file or directory"),
    ('<param name="a" command=" "/>', "Cannot load command parameter [a]: the command is empty"),
    ('<param name="a" command="echo \'"/>', "Cannot load command parameter [a]: No closing quotation in [echo ']"),
    ('<param name="a" command="false"/>', "Cannot load command parameter [a]: false has failed"),
    ('<rosparam command="delete" param="a" file="f"/>', "file attribute is not allowed for delete"),
    ('<rosparam command="dump" param="a"/>', "file attribute is required for dump"),
    ('<rosparam command="save" param="a"/>', "command must be 'load', 'dump', or 'delete'"),
    ('<rosparam file="nothing"/>', "error loading <rosparam> tag: "),
    ("<rosparam>5</rosparam>", "'param' attribute must be set for non-dictionary values"),
    ('<rosparam ns="/">5</rosparam>', "only a dictionary can be loaded into the namespace '/'"),
    ('<rosparam ns="a">{1: 2}</rosparam>', "parameter names must be strings, not 1"),
]
TAGS = [
    ('<arg name="a" value="1" default="2"/>', "Invalid <arg> tag: it must have one and only one of value/default"),
    ('<arg value="1"/>', "Invalid <arg> tag: 'name' is missing"),
    ('<group ns=""/>', "<group> tag has an empty 'ns' attribute"),
    ('<group clear_params="true"/>', "'ns' attribute must be set in order to use 'clear_params'"),
    ('<group if="1" unless="0"/>', "cannot set both 'if' and 'unless' on the same tag"),
    ("<include/>", "<include> tag is missing required attribute: 'file'"),
    ('<include file="nothing"/>', "cannot read [nothing]: No such file or directory"),
    ('<include file="part"><arg name="a"/></include>', "arg 'a' of an <include> needs a 'value'"),
    ('<remap from="a"/>', "<remap> tag is missing required from/to attributes"),
    ('<remap from="a b" to="c"/>', "remap from [a b] is not a valid ROS name"),
    ('<remap from="a" to="1"/>', "remap to [1] is not a valid ROS name"),
    ('<env name="A"/>', "<env> tag is missing required name/value attributes"),
    ('<env name="A=B" value="1"/>', "not a valid name or value of an environment variable: 'A=B'"),
    ('<group ns="~private"/>', "a namespace cannot be private: ~private"),
]


@pytest.mark.parametrize(("text", "said"), [*NODES, *PARAMS, *TAGS])
def test_tags_that_are_refused(text: str, said: str) -> None:
    with pytest.raises(LaunchError) as refusal:
        load(text, part="<launch/>")
    assert said in str(refusal.value) and str(refusal.value).startswith("main.launch:2: ")


def test_a_test_is_read_with_its_limits() -> None:
    (test,) = load(f'{TEST} time-limit="1.5" retry="-2"/>').tests
    assert (test.full_name, test.test_name, test.time_limit, test.retry) == ("/it", "it", 1.5, 0)


def test_names_that_other_tools_may_refuse_are_warned_of() -> None:
    assert "[main.launch:2] illegal <node> name 'a-b'" in load('<node pkg="p" type="t" name="a-b"/>').warnings[0]


def test_the_delay_of_a_respawn_is_kept_within_a_day() -> None:
    nodes = load("".join(f'{NODE[:-1]}{delay}" respawn_delay="{delay}"/>' for delay in ("1e9", "-1", "2.5"))).nodes
    assert [node.exit_policy.respawn_delay for node in nodes] == [86400.0, 0.0, 2.5]


def test_parameters_of_a_node_can_be_cleared() -> None:
    plan = load(f'<group ns="g">{NODE} clear_params="true"/><node pkg="p" type="t" name="m" clear_params=""/></group>')
    assert plan.clear_params == ["/g/n/"]


def test_the_tag_of_a_master_is_ignored_with_a_warning() -> None:
    assert load('<master auto="start"/>').warnings == ["ignoring defunct <master /> tag"]


def test_a_file_that_is_outdated_says_so() -> None:
    files = {"part": '<launch deprecated="use whole"/>'}
    assert load('<include file="part"/>', **files).warnings == ["[part] DEPRECATED: use whole"]


def test_nodes_of_a_group_wait_for_what_the_group_waits_for() -> None:
    inner = f'<group wait-for="node:/b">{NODE} wait-for="param:c"/></group>'
    (node,) = load(f'<group wait-for="topic:/a" wait-timeout="5">{inner}</group>').nodes
    assert [str(condition) for condition in node.wait_for] == ["topic:/a", "node:/b", "param:/c"]
    assert node.wait_timeout == 5.0
