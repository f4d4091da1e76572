"""Stock rosparam under both masters, and pyros1's nodes reading what it wrote."""

from __future__ import annotations

from pathlib import Path

from harness import Master, Peer

VALUES = {
    "int": ("7", "7"),
    "float": ("0.25", "0.25"),
    "boolean": ("true", "true"),
    "text": ("hello world", '"hello world"'),
    "unicode": ("Grüße 🤖", '"Grüße 🤖"'),
    "list": ("[1, two, [3.5]]", '[1, "two", [3.5]]'),
    "dict": ("{a: 1, b: {c: x}}", '{"a": 1, "b": {"c": "x"}}'),
}


def test_set_get_list_delete(ours: Peer, master: Master, topic: str) -> None:
    for name, (value, shown) in VALUES.items():
        key = f"{topic}/{name}"
        master.tool("rosparam", "set", key, value)
        assert ours.ask("getparam", key) == shown
    assert master.tool("rosparam", "get", topic + "/float") == "0.25\n"
    assert master.tool("rosparam", "get", topic + "/dict") == "a: 1\nb:\n  c: x\n\n"
    listed = [line for line in master.tool("rosparam", "list").splitlines() if line.startswith(topic + "/")]
    plain = {f"{topic}/{name}" for name in VALUES if name != "dict"}
    assert set(listed) == plain | {f"{topic}/dict/a", f"{topic}/dict/b/c"}
    master.tool("rosparam", "delete", topic + "/dict")
    assert ours.ask("hasparam", topic + "/dict") == "0"
    assert "is not set" in master.tool("rosparam", "get", topic + "/dict", code=1)


def test_load_and_dump(ours: Peer, master: Master, topic: str, tmp_path: Path) -> None:
    source = tmp_path / "in.yaml"
    source.write_text("a: 1\nb:\n  c: [1.5, true, text]\n  angle: deg(180)\n", encoding="utf-8")
    master.tool("rosparam", "load", str(source), topic)
    assert ours.ask("getparam", topic + "/b/c") == '[1.5, true, "text"]'
    assert ours.ask("getparam", topic + "/b/angle").startswith("3.14159")
    target = tmp_path / "out.yaml"
    master.tool("rosparam", "dump", str(target), topic)
    assert target.read_text(encoding="utf-8").startswith("a: 1\nb:\n  angle: 3.14159")


def test_what_our_node_set(ours: Peer, master: Master, topic: str) -> None:
    ours.ask("setparam", topic, "list", event=f"set {topic}")
    assert master.tool("rosparam", "get", topic) == "- 1\n- two\n- 3.5\n- - true\n\n"
