"""rosout: everything that nodes log, in one topic and one file (L21)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from pyros1.ground.timing import Time
from pyros1.msgs.rosgraph_msgs.msg import Log as LogMessage
from pyros1.msgs.std_msgs.msg import Header
from pyros1.node.log.rosout import RosoutAggregator


def message(number: int = 0, **fields: Any) -> Any:
    fields = {"msg": f"text {number}", "topics": ["/a", "/b"], **fields}
    header = Header(stamp=Time(12, 34))
    return LogMessage(header=header, level=4, name="/n", file="f.py", function="go", line=9, **fields)


@pytest.fixture
def aggregate(make_node: Any, tmp_path: Path, collect: Any) -> Any:
    """Return a function that sends messages through an aggregator and returns what was published and written."""

    def run(*messages: Any, path: Path | None = tmp_path / "log" / "rosout.log") -> tuple[list[Any], str]:
        node, observer, talker, got = make_node("rosout"), make_node("observer"), make_node("talker"), collect()
        RosoutAggregator(node, None if path is None else str(path))
        subscriber = observer.subscribe("/rosout_agg", LogMessage, got)
        publisher = talker.advertise("/rosout", LogMessage)
        assert publisher.wait_for_subscribers(timeout=20)
        assert subscriber.wait_for_publishers(timeout=20)
        for item in messages:
            publisher.publish(item)
        assert got.until(lambda items: len([m for m in items if m.name == "/n"]) >= len(messages))
        node.shutdown()
        text = path.read_text(encoding="utf-8") if path is not None and path.exists() else ""
        return [m for m in got.items if m.name == "/n"], text

    return run


def test_everything_is_published_again_and_written(aggregate: Any) -> None:
    published, text = aggregate(message(1), message(2, topics=[], msg="zwei\nZeilen ä"))
    assert [m.msg for m in published] == ["text 1", "zwei\nZeilen ä"]
    assert published[0].topics == ["/a", "/b"] and published[0].header.stamp == Time(12, 34)
    lines = [line for line in text.splitlines(keepends=True) if " /n " in line or "Zeilen" in line]
    assert lines == [
        "12.000000034 WARN /n [f.py:9(go)] [topics: /a, /b] text 1\n",
        "12.000000034 WARN /n [f.py:9(go)] [topics: ] zwei\n",
        "Zeilen ä\n",
    ]


def test_topics_may_be_left_out(aggregate: Any, make_node: Any) -> None:
    make_node("setter").params["/rosout/omit_topics"] = True
    _, text = aggregate(message(1))
    assert "12.000000034 WARN /n [f.py:9(go)] text 1\n" in text


@pytest.mark.parametrize("value", ["1", "True", "on", "yes"])
def test_the_file_may_be_disabled_n34(aggregate: Any, environ: dict[str, str], tmp_path: Path, value: str) -> None:
    environ["ROSOUT_DISABLE_FILE_LOGGING"] = value
    published, text = aggregate(message(1))
    assert len(published) == 1 and text == "" and not (tmp_path / "log").exists()


def test_without_a_file(aggregate: Any) -> None:
    assert len(aggregate(message(1), path=None)[0]) == 1


def test_rotation(aggregate: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.node.log.rosout.MAX_FILE_SIZE", 10)
    monkeypatch.setattr("pyros1.node.log.rosout.MAX_BACKUPS", 3)
    path = tmp_path / "rosout.log"
    aggregate(*[message(number) for number in range(6)], path=path)
    assert sorted(p.name for p in tmp_path.glob("rosout.log*")) == [f"rosout.log.{n}" for n in (1, 2, 3)]
    assert "text 5" in (tmp_path / "rosout.log.1").read_text()


def test_a_file_that_cannot_be_written_stops_nothing(aggregate: Any, tmp_path: Path, capsys: Any) -> None:
    (tmp_path / "file").write_text("")
    published, _ = aggregate(message(1), message(2), path=tmp_path / "file" / "rosout.log")
    assert len(published) == 2
    assert capsys.readouterr().err.count("cannot write") == 1
