"""Publishers as other client libraries are, with random headers, definitions and bytes: what stock shows, we show.

Stock's subscribers know only the types that are installed, whatever a publisher says of its type. Ours are tried in
three ways: as a rospy program, as our tools decode messages of any type, and in a bag that holds what was received.

Feature: publishers written with other client libraries: unusual headers and definitions, surplus bytes -- random
    ones; we receive what stock's subscribers and tools receive
"""

from __future__ import annotations

import contextlib
import json
import random
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import faces
import pytest
import raw
from harness import Master, Process, until
from samples import FORMULAS, Samples

import pyros1.bag
from pyros1 import AnyMsg, Duration, Node, Time
from pyros1.ground.errors import Error
from pyros1.msgs import load_message
from pyros1.observe.decoder import Decoder

SUBSCRIBER = (Path(__file__).parents[1] / "peers" / "foreign_subscriber.py").read_text()
SEPARATOR = "\n" + "=" * 80 + "\n"
TYPES = sorted(set(FORMULAS) - {"std_msgs/Empty"})
CASES = 60

pytestmark = [pytest.mark.ours_only, pytest.mark.filterwarnings("ignore::UnicodeWarning")]


class Case(NamedTuple):
    """What a publisher sends.

    Attributes:
        kind: name of the type, which the master is told.
        fields: of the header.
        bodies: the messages: an odd one and a good one.
        known: whether the header has that type, and its md5 or any.
        refused: whether a field is missing; stock's subscriber does not hang up at once.
        what: what is odd.
    """

    kind: str
    fields: list[bytes]
    bodies: list[bytes]
    known: bool
    refused: bool
    what: str


def separated(text: str, separator: str) -> str:
    return text.replace(SEPARATOR, separator)


TEXTS: dict[str, Callable[[str, random.Random], str | bytes | None]] = {
    "as stock": lambda text, _: text,
    "no definition": lambda text, _: None,
    "empty": lambda text, _: "",
    "blank": lambda text, _: " \n\t\n",
    "a comment": lambda text, _: "# generated",
    "without nested types": lambda text, _: text.split(SEPARATOR)[0],
    "cut": lambda text, rng: text[: rng.randrange(len(text))],
    "cut at a line": lambda text, rng: "\n".join(text.split("\n")[: rng.randrange(1, 9)]),
    "without its beginning": lambda text, rng: text[rng.randrange(len(text)) :],
    "short separators": lambda text, rng: separated(text, "\n" + "=" * rng.choice((3, 40, 79)) + "\n"),
    "long separators": lambda text, _: separated(text, "\n" + "=" * 81 + " \n"),
    "dashes": lambda text, _: separated(text, "\n---\n"),
    "no separators": lambda text, _: separated(text, "\n"),
    "blank lines": lambda text, _: separated(text, "\n\n" + SEPARATOR + "\n"),
    "no titles": lambda text, _: re.sub("MSG: .*\n", "", text),
    "titles without a space": lambda text, _: text.replace("MSG: ", "MSG:"),
    "titles of ROS 2": lambda text, _: re.sub(r"MSG: (\w+)/", r"MSG: \1/msg/", text),
    "titles without a package": lambda text, _: re.sub(r"MSG: \w+/", "MSG: ", text),
    "line ends": lambda text, _: text.replace("\n", "\r\n"),
    "one line": lambda text, _: text.replace("\n", " "),
    "escaped line ends": lambda text, _: text.replace("\n", "\\n"),
    "tabs": lambda text, _: text.replace(" ", "\t"),
    "indented": lambda text, _: re.sub("^", "  ", text, flags=re.MULTILINE),
    "garbled": lambda text, rng: "".join(rng.choice("x%[]= ") if rng.random() < 0.05 else each for each in text),
    "another type's": lambda text, _: "float64 value\nstring unit\n",
    "ROS 2": lambda text, _: re.sub(r"\btime\b", "builtin_interfaces/Time", text),
    "XML": lambda text, _: f"<definition><![CDATA[{text}]]></definition>",
    "not UTF-8": lambda text, _: b"# \xb0C\n" + text.encode(),
    "large": lambda text, _: text + "# padding\n" * 50_000,
}
HEADERS: dict[str, Callable[[dict[bytes, bytes], random.Random], None]] = {
    "any md5": lambda fields, _: fields.update({b"md5sum": b"*"}),
    "no such md5": lambda fields, rng: fields.update({b"md5sum": rng.randbytes(16).hex().encode()}),
    "an md5 in capitals": lambda fields, _: fields.update({b"md5sum": fields[b"md5sum"].upper()}),
    "an empty md5": lambda fields, _: fields.update({b"md5sum": b""}),
    "without md5": lambda fields, _: fields.pop(b"md5sum") and None,
    "any type": lambda fields, _: fields.update({b"type": b"*"}),
    "no such type": lambda fields, _: fields.update({b"type": b"own_msgs/Thing"}),
    "a ROS 2 type": lambda fields, _: fields.update({b"type": fields[b"type"].replace(b"/", b"/msg/")}),
    "another type": lambda fields, _: fields.update({b"type": b"std_msgs/Float32"}),
    "an empty type": lambda fields, _: fields.update({b"type": b""}),
    "without type": lambda fields, _: fields.pop(b"type") and None,
    "without callerid": lambda fields, _: fields.pop(b"callerid") and None,
    "without topic": lambda fields, _: fields.pop(b"topic") and None,
    "another topic": lambda fields, _: fields.update({b"topic": b"elsewhere"}),
    "without latching": lambda fields, _: fields.pop(b"latching") and None,
    "latching": lambda fields, _: fields.update({b"latching": b"1"}),
    "odd latching": lambda fields, _: fields.update({b"latching": b"true"}),
    "more fields": lambda fields, rng: fields.update({b"x": b"a=b", b"y": b"", rng.randbytes(3).hex().encode(): b" "}),
    "an error": lambda fields, _: fields.update({b"error": b"no"}),
}


def changed(body: bytes, rng: random.Random) -> bytes:
    place = rng.randrange(len(body))
    return body[:place] + bytes([rng.choice((0, 1, 255, rng.randrange(256)))]) + body[place + 1 :]


BODIES: dict[str, Callable[[bytes, random.Random], bytes]] = {
    "a good message": lambda body, _: body,
    "bytes behind it": lambda body, rng: body + rng.randbytes(rng.choice((1, 2, 4, 100))),
    "the same again behind it": lambda body, _: body + body,
    "zeros behind it": lambda body, _: body + bytes(4),
    "cut": lambda body, rng: body[: rng.randrange(len(body))],
    "the last bytes missing": lambda body, rng: body[: -rng.randrange(1, min(5, len(body)) + 1)],
    "a byte changed": changed,
    "empty": lambda body, _: b"",
}


def cases(rng: random.Random, count: int) -> Iterator[Case]:
    """Every oddity in its turn, with others by chance."""
    samples = Samples(lambda name: load_message(name)(), Time, Duration)
    texts, headers, bodies = list(TEXTS), list(HEADERS), list(BODIES)
    for number in range(count):
        kind = rng.choice(TYPES)
        cls: Any = load_message(kind)
        good, odd = (cls._encode(samples.build(kind, seed)) for seed in (1, 2))
        text = texts[number % len(texts)] if number < len(texts) else rng.choice(texts)
        body = bodies[number % len(bodies)] if rng.random() < 0.8 else bodies[0]
        header = [headers[number % len(headers)]] if rng.random() < 0.4 else []
        definition = TEXTS[text](cls._full_text, rng)
        fields = {
            b"callerid": b"/foreign",
            b"md5sum": cls._md5sum.encode(),
            b"type": kind.encode(),
            b"topic": b"/any",
            b"latching": b"0",
        }
        if definition is not None:
            fields[b"message_definition"] = definition if isinstance(definition, bytes) else definition.encode()
        for name in header:
            HEADERS[name](fields, rng)
        lines = [name + b"=" + value for name, value in fields.items()]
        if rng.random() < 0.3:
            rng.shuffle(lines)
        what = f"{kind}: {text}, {header}, {body}"
        md5s = (cls._md5sum.encode(), b"*")
        known = fields.get(b"type") == kind.encode() and fields.get(b"md5sum") in md5s
        refused = b"error" in fields or not fields.keys() >= {b"type", b"md5sum"}
        yield Case(kind, lines, [BODIES[body](odd, rng), good], known, refused, what)


class Viewer:
    """Shows messages as our tools do, and writes them into a bag."""

    def __init__(self, node: Node, topics: dict[str, str], bag: Path) -> None:
        self.texts: dict[str, list[str]] = {topic: [] for topic in topics}
        self.count = dict.fromkeys(topics, 0)
        self._bag = pyros1.bag.open(bag, "w")
        for topic, kind in topics.items():
            node.subscribe(topic, AnyMsg, self._taker(topic, Decoder(kind)))

    def _taker(self, topic: str, decoder: Decoder) -> Callable[[AnyMsg], None]:
        def take(message: AnyMsg) -> None:
            header = {"message_definition": "", **(message._connection_header or {})}
            self._bag.write_raw(topic, message._buff, header)
            with contextlib.suppress(Error):
                self.texts[topic].append(str(decoder.decode(message)))
            self.count[topic] += 1

        return take

    def close(self) -> None:
        self._bag.close()


@pytest.fixture
def viewing_node(master: Master) -> Iterator[Node]:
    environ = {"ROS_MASTER_URI": master.uri, "ROS_HOSTNAME": "localhost", "ROS_LOG_DIR": str(master.home / "log")}
    with Node("viewer", argv=[], environ=environ, handle_signals=False, rosout=False) as node:
        yield node


def subscriber(face: str, launcher: Master, topics: dict[str, str]) -> Process:
    process = faces.start(face, launcher, SUBSCRIBER, f"foreign_subscriber_{face}")
    process.write(json.dumps(topics))
    return process


def received(process: Process) -> dict[str, list[str]]:
    process.write("?")
    found: dict[str, list[str]] = json.loads(process.wait_line(r"^\{.*\}$").string)
    return found


@pytest.mark.parametrize("seed", range(2))
def test_what_stock_shows_we_show(
    launcher: Master, topic: str, seed: int, viewing_node: Node, tmp_path: Path, long: bool
) -> None:
    """With ``--long`` many more cases, with a new seed."""
    if long:
        seed = random.randrange(1 << 30)
    wanted = {
        f"{topic}/t{number}": case for number, case in enumerate(cases(random.Random(seed), CASES * (1 + 2 * long)))
    }
    topics = {name: case.kind for name, case in wanted.items()}
    with raw.foreign_node(launcher, f"/foreign{seed}") as foreign:
        for name, case in wanted.items():
            foreign.publish(name, case.kind, case.fields, case.bodies)
        programs = {face: subscriber(face, launcher, topics) for face in faces.FACES}
        viewer = Viewer(viewing_node, topics, tmp_path / "received.bag")
        ends = {face: f"/foreign_subscriber_{face}" for face in faces.FACES}
        got: dict[str, dict[str, list[str]]] = {}

        good = {name: str(decoded(case.kind, case.bodies[1])) for name, case in wanted.items()}

        def missing() -> list[str]:
            """Who still waits for a good message, and has not hung up."""
            got.update({face: received(program) for face, program in programs.items()})
            here = {
                "/viewer": {name for name, count in viewer.count.items() if count == 2},
                **{ends[face]: {name for name in wanted if good[name] in got[face][name]} for face in ends},
            }
            return [
                f"{who} {name} {wanted[name].what}"
                for who, names in here.items()
                for name in wanted
                if name not in names and not foreign.has_ended(name, who) and not wanted[name].refused
            ]

        try:
            until(lambda: not missing(), "", timeout=60)
        except AssertionError:
            pytest.fail(f"seed {seed}: no good message, nor a hang-up: {missing()}")
        finally:
            viewer.close()
    bag = in_bag(tmp_path / "received.bag")
    wrong = []
    for name, case in wanted.items():
        stock = got["stock"][name]
        for who, texts in (("rospy", got["ours"][name]), ("tools", viewer.texts[name]), ("bag", bag.get(name, []))):
            if who == "bag" and not case.known:
                continue  # the bag has no other type than that of the header
            if texts[: len(stock)] != stock:
                wrong.append(f"seed {seed}, {name}, {case.what}: {who} has {texts}, stock {stock}")
    assert not wrong, "\n".join(wrong)
    assert sum(map(len, got["stock"].values())) > CASES


def decoded(kind: str, body: bytes) -> Any:
    return load_message(kind)().deserialize(body)


def in_bag(path: Path) -> dict[str, list[str]]:
    """The messages of a bag as text, those that can be read."""
    texts: dict[str, list[str]] = {}
    with pyros1.bag.open(path) as bag:
        for name, message, _, connection in bag.messages(raw=True):
            with contextlib.suppress(Error):
                cls = bag.message_class(connection)
                texts.setdefault(name, []).append(str(cls().deserialize(message._buff)))
    return texts
