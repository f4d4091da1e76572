"""Random launch files with all tags and attributes, most of them fine, and the files that they include or read."""

from __future__ import annotations

import random
import re
from collections.abc import Callable
from pathlib import Path
from xml.sax.saxutils import escape, quoteattr

WORDS = ("robot1", "robot_2", "arm", "base", "nav", "camera")
VALUES = (
    "1",
    "0",
    "-3",
    "2.5",
    "1e3",
    "true",
    "False",
    "a word",
    "",
    " 7 ",
    "0x10",
    "1_000",
    "nan",
    "[1, 2]",
    "{a: 1}",
)
YAMLS = (
    "{a: 1, b: {c: [1, 2.5, x]}}",
    "rate: 10\nlimits:\n  linear: 0.5\n  angular: rad(pi/2)",
    "base: $(arg name)/base_link\nodom: $(arg name)/odom",
    "a: 1\n$(arg name): {rate: $(arg number)}",
    "{}",
    "",
    "[1, 2, 3]",
    "text",
    "a: $(eval 1 + 1)",
    "a: {b: $(anon who)}",
)


class Launches:
    """Writes launch files that include each other into a folder.

    Args:
        chance: where the random choices come from.
        folder: where the files are written; ``main.launch`` is the one to be launched.
    """

    def __init__(self, chance: random.Random, folder: Path) -> None:
        self._chance = chance
        self._folder = folder
        self._numbers = 0

    def write(self) -> list[str]:
        """Write ``main.launch`` and what it needs; return arguments for its command line."""
        for number, text in enumerate(YAMLS):
            (self._folder / f"values{number}.yaml").write_text(text)
        (self._folder / "text.txt").write_text("some text\n")
        self._launch("main.launch", depth=2)
        given = {
            "name": self._pick("x", "r1", "7"),
            "number": self._pick("4", "0.5", "1e2"),
            "on": self._pick("true", "0"),
        }
        return [f"{name}:={value}" for name, value in given.items() if self._often(0.3)]

    def _launch(self, name: str, depth: int) -> None:
        args = [self._arg(each) for each in ("name", "number", "on") if self._often(0.99)]
        body = [self._tag(depth) for _ in range(self._chance.randrange(3, 9))]
        (self._folder / name).write_text("\n".join(["<launch>", *args, *body, "</launch>"]))

    def _tag(self, depth: int) -> str:
        makers: list[Callable[[], str]] = [
            self._node, self._node, self._param, self._rosparam, self._remap, self._remap, self._env, self._test,
            lambda: self._arg(f"more{self._number()}"), self._machine,
        ]  # fmt: skip
        if depth:
            makers += [lambda: self._group(depth - 1)] * 3 + [lambda: self._include(depth - 1)] * 3
        return self._chance.choice(makers)()

    def _group(self, depth: int) -> str:
        body = [self._tag(depth) for _ in range(self._chance.randrange(5))]
        ns = self._sometimes("ns", self._namespace, 0.7)
        return self._element("group", {**ns, **(self._sometimes("clear_params", self._flag, 0.1) if ns else {})}, body)

    def _include(self, depth: int) -> str:
        self._numbers += 1
        name = f"part{self._numbers}.launch"
        self._launch(name, depth)
        file = self._pick("$(dirname)/", f"{self._folder}/", "$(dirname)/./") + name
        attributes = {
            "file": file,
            **self._sometimes("ns", self._namespace),
            **self._sometimes("pass_all_args", self._flag),
        }
        if "ns" in attributes:
            attributes |= self._sometimes("clear_params", self._flag, 0.1)
        body = [self._given(each) for each in ("name", "number", "on", "unused") if self._often(0.35)]
        body += [self._env() for _ in range(self._often(0.2))]
        return self._element("include", attributes, body)

    def _given(self, name: str) -> str:
        if name == "unused" and self._often(0.97):
            return ""
        value = {"name": self._word(), "number": self._pick("4", "$(arg number)"), "on": self._truth()}.get(name, "1")
        return self._element("arg", {"name": name, self._pick("value", "value", "default"): value})

    def _arg(self, name: str) -> str:
        usual = {"name": ("r1", "robot", *WORDS), "number": ("3", "0.5", "12"), "on": ("true", "false", "1", "0")}
        value = self._pick(*usual[name]) if name in usual else self._value()
        attributes = {"name": name, "value" if self._often(0.01) else "default": value}
        if self._often(0.01):
            attributes.pop("default", None)
        attributes |= self._sometimes("doc", lambda: "what it is", 0.1)
        return self._element("arg", attributes, conditions=name not in usual)

    def _node(self) -> str:
        body = [
            self._chance.choice((self._param, self._rosparam, self._remap, self._env))() for _ in range(self._few())
        ]
        return self._element("node", {**self._program(), **self._sometimes("ns", self._namespace, 0.3)}, body)

    def _test(self) -> str:
        attributes = {
            **self._program(node=False),
            "test-name": f"t{self._number()}",
            **self._sometimes("ns", self._namespace, 0.3),
            **self._sometimes("time-limit", lambda: self._pick("3", "2.5", "1"), 0.3),
            **self._sometimes("retry", lambda: self._pick("0", "2"), 0.3),
        }
        if self._often(0.3):
            del attributes["name"]
        return self._element(
            "test",
            attributes,
            [self._chance.choice((self._param, self._remap, self._env))() for _ in range(self._few())],
        )

    def _program(self, node: bool = True) -> dict[str, str]:
        number = self._number()
        found = {
            "pkg": self._pick("topic_tools", "topic_tools", "no_such", "$(arg name)"),
            "type": self._pick("relay", "mux", "$(arg name)_node", "sub/program.py"),
            "name": self._pick(f"n{number}", f"$(arg name)_{number}", f"$(anon n{number})", f"n{number}$(arg number)"),
            **self._sometimes(
                "args", lambda: self._pick("/in /out", "'two words' --flag", "_x:=$(arg number)", self._value())
            ),
            **self._sometimes("launch-prefix", lambda: self._pick("nice -n 5", "", "$(optenv NOT_SET time)"), 0.1),
            **self._sometimes("clear_params", self._flag, 0.05),
            **self._sometimes("cwd", lambda: self._pick("node", "ROS_HOME"), 0.1),
            **self._sometimes("machine", lambda: self._pick("near", "far", ""), 0.03),
        }
        if node:
            found |= {
                **self._sometimes("output", lambda: self._pick("screen", "log", "$(optenv OUT screen)")),
                **self._sometimes(self._pick("respawn", "required"), self._flag, 0.1),
                **self._sometimes("respawn_delay", lambda: self._pick("1", "0.5"), 0.1),
            }
        return found

    def _param(self) -> str:
        command = f"echo {self._pick('5', 'words', '$(arg name)', '{a: [1]}')}"
        kinds: list[Callable[[], dict[str, str]]] = [
            self._typed,
            lambda: {"textfile": "$(dirname)/text.txt"},
            lambda: {"command": command, **self._sometimes("type", lambda: self._pick("yaml", "str"))},
        ]  # fmt: skip
        value = kinds[0]() if self._often(0.8) else self._chance.choice(kinds)()
        return self._element("param", {"name": self._name(), **value})

    def _typed(self) -> dict[str, str]:
        typed = {"int": " 7", "double": "1e3", "bool": "true"}
        kind = self._pick("str", "string", "auto", "yaml", *typed)
        value = typed.get(kind, self._value()) if self._often(0.99) else self._value()
        return {"value": value, "type": kind} if self._often(0.5) else {"value": self._value()}

    def _rosparam(self) -> str:
        where = {**self._sometimes("param", self._name), **self._sometimes("ns", self._namespace)}
        subst = self._sometimes("subst_value", self._flag, 0.5)
        number = self._chance.randrange(len(YAMLS))
        kind = self._chance.random()
        if kind < 0.1:
            return self._element("rosparam", {"command": "delete", **(where or {"param": self._name()})})
        if kind < 0.15:
            return self._element("rosparam", {"command": "dump", "file": "$(dirname)/dumped.yaml", **where})
        if kind < 0.5:
            return self._element(
                "rosparam",
                {
                    **self._sometimes("command", lambda: "load"),
                    "file": f"$(dirname)/values{number}.yaml",
                    **where,
                    **subst,
                },
            )
        return self._element("rosparam", {**where, **subst}, [escape(YAMLS[number])])

    def _remap(self) -> str:
        return self._element("remap", {"from": self._name(), "to": self._name()})

    def _env(self) -> str:
        return self._element("env", {"name": self._pick("A", "B", "ROS_NAMESPACE", "HOME"), "value": self._value()})

    def _machine(self) -> str:
        return self._element("machine", {
            "name": f"m{self._number()}",
            "address": self._pick("localhost", "127.0.0.1", "robot.example"),
            **self._sometimes("env-loader", lambda: self._pick("/opt/env.sh", "")),
            **self._sometimes("user", lambda: self._pick("me", "$(optenv NOT_SET)")),
            **self._sometimes("password", lambda: "secret", 0.1),
            **self._sometimes("ssh-port", lambda: self._pick("22", "2200")),
            **self._sometimes("timeout", lambda: self._pick("10", "2.5")),
            **self._sometimes("default", lambda: self._pick("true", "false", "never", "TRUE", "FALSE"), 0.05),
        })  # fmt: skip

    def _element(
        self, tag: str, attributes: dict[str, str], body: list[str] | None = None, conditions: bool = True
    ) -> str:
        if conditions and self._often(0.2):
            attributes = {**attributes, self._pick("if", "unless"): self._truth()}
        items = list(attributes.items())
        self._chance.shuffle(items)
        opened = f"<{tag}" + "".join(f" {name}={quoteattr(value)}" for name, value in items)
        inner = [each for each in body or [] if each]
        return "\n".join([f"{opened}>", *inner, f"</{tag}>"]) if inner else f"{opened}/>"

    def _namespace(self) -> str:
        return self._pick(
            *WORDS,
            "$(arg name)",
            "/",
            f"/{self._pick(*WORDS)}",
            "a/b",
            "/a/b/",
            "arm//",
            "$(arg name)/$(arg number)",
            "$(eval 'r' + str(number))",
        )

    def _name(self) -> str:
        base = self._pick(*WORDS, "scan", "cmd_vel", "tf")
        return self._pick(
            base,
            base,
            f"/{base}",
            f"~{base}",
            f"$(arg name)/{base}",
            f"/$(arg name)/{base}",
            f"{base}/inner",
            f"{base}/",
            f"a//{base}",
            f"~{base}/x",
            "$(eval name + '/tf')",
        )

    def _value(self) -> str:
        return self._pick(
            *VALUES, "$(arg name)", "$(arg number)", "$(arg name)/base_link", "$(eval number)", "$(eval 1 + 2)",
            "$(eval name + '_x')", "$(eval arg('number') == 3)", "$(optenv NOT_SET)", "$(optenv NOT_SET a b)",
            "$(env HOME)",
            "$(anon who)", "$(dirname)", "$(find topic_tools)", "$(eval 'a' if on else 'b')",
            *(["$(arg missing)"] if self._often(0.01) else []),
        )  # fmt: skip

    def _truth(self) -> str:
        return self._pick(
            "true", "false", "1", "0", "True", "$(arg on)", "$(arg on)", "$(eval name == 'r1')", "$(eval not on)"
        )

    def _flag(self) -> str:
        return self._pick("true", "false", "True", "$(arg on)") if self._often(0.02) else self._pick("true", "false")

    def _word(self) -> str:
        return self._pick(*WORDS, "$(arg name)", "$(arg name)_2", "$(eval name + '_x')", "$(anon who)")

    def _sometimes(self, name: str, make: Callable[[], str], share: float = 0.25) -> dict[str, str]:
        return {name: make()} if self._often(share) else {}

    def _pick(self, *choices: str) -> str:
        return self._chance.choice(choices)

    def _often(self, share: float) -> bool:
        return self._chance.random() < share

    def _few(self) -> int:
        return self._chance.choice((0, 0, 1, 2, 3))

    def _number(self) -> int:
        self._numbers += 1
        return self._numbers


ODD = (
    "", " ", "~", "/", "//", "a b", "~a", "a/~b", "é", "1a", "-a", "a-b", "a.b", "true ", "TRUE", "yes", "1.0",
    "-1", "1e400", "inf", "0x1f", "5_0", "None", "null", "{a: 1}", "[1", "'x", "\\", "%s", "{}", "`x`", "&amp;",
    "&lt;", "&#10;", "$(arg name", "$(arg)", "$(arg  name)", "$( arg name)", "$(ARG name)", "$(env)", "$(optenv)",
    "$(optenv NOT_SET)", "$(find)", "$(find nope)", "$(find topic_tools)/nope", "$(anon)", "$(eval)",
    "$(eval 1+1)x", "x$(eval 1)", "$()", "$(", "$(nope x)", "$$(arg name)", "screen", "both", "node", "never",
    "load", "delete", "Load", "int", "bool", "yaml", "STR",
)  # fmt: skip
TAGS = (
    "node",
    "param",
    "rosparam",
    "remap",
    "env",
    "machine",
    "test",
    "group",
    "include",
    "arg",
    "master",
    "launch",
    "Node",
)
ATTRIBUTES = (
    "name", "ns", "clear_params", "if", "unless", "pkg", "type", "args", "machine", "respawn", "required", "output",
    "cwd", "value", "textfile", "command", "file", "param", "subst_value", "from", "to", "default", "doc",
    "address", "user", "timeout", "pass_all_args", "test-name", "time-limit", "retry", "deprecated", "ros-root",
    "bogus",
)  # fmt: skip
PARTS = (
    "<!-- note -->", "text", "<![CDATA[x: 1]]>", "<param name='z' value='1'/>", "<group/>", "<bogus/>", "<?pi x?>",
    "<node pkg='p' type='t' name='zz'/>", "<remap from='a' to='b'/>",
)  # fmt: skip


def spoil(chance: random.Random, text: str) -> str:
    """Return a launch file with mistakes: odd values, attributes and tags that are missing or misplaced."""
    for _ in range(chance.choice((1, 1, 2, 3))):
        kind = chance.random()
        pattern = r'([\w-]+)="([^"]*)"' if kind < 0.75 else r"<([a-z]+)(?=[ >/])" if kind < 0.93 else "()>"
        found = chance.choice(list(re.finditer(pattern, text)))
        before, after = text[: found.start()], text[found.end() :]
        if kind < 0.6:
            middle = f'{found[1]}="{chance.choice(ODD)}"'
        elif kind < 0.75:
            middle = ""
        elif kind < 0.85:
            middle = f'{found[0]} {chance.choice(ATTRIBUTES)}="{chance.choice(ODD)}"'
        elif kind < 0.93:
            middle = f"<{chance.choice(TAGS)}" if text[found.end() :].partition(">")[0].endswith("/") else found[0]
        else:
            middle = found[0] + chance.choice(PARTS)
        text = before + middle + after
    return text
