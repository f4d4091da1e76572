"""Definition texts that other client libraries send: which class is used for their messages."""

from __future__ import annotations

import random
import re
from collections.abc import Callable
from typing import Any

import pytest

from pyros1.ground.errors import DefinitionError, UnknownTypeError
from pyros1.msgs import AnyMsg, DefinitionCache, from_definition, load_message
from pyros1.msgs.dynamic import MAX_TEXT_LENGTH
from pyros1.msgs.nonstandard_definitions import find_class

SEPARATOR = "\n" + "=" * 80 + "\n"
POSE: Any = load_message("geometry_msgs/PoseStamped")
OWN: Any = from_definition(  # not installed, with nested types of which some are
    "own_msgs/Robot",
    SEPARATOR.join(
        [
            "Header header\nPart[] parts\ngeometry_msgs/Pose pose\nfloat64 LIMIT=3 # m",
            "MSG: own_msgs/Part\nstring name\ngeometry_msgs/Vector3 size",
            "MSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id",
            "MSG: geometry_msgs/Pose\nPoint position\nQuaternion orientation",
            "MSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z",
            "MSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w",
            "MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z",
        ]
    ),
)
READABLE: dict[str, Callable[[str], str]] = {
    "as it is": lambda text: text,
    "short separators": lambda text: text.replace(SEPARATOR, "\n====================\n"),
    "long separators": lambda text: text.replace(SEPARATOR, "\n" + "=" * 90 + "  \n"),
    "dashes": lambda text: text.replace(SEPARATOR, "\n" + "-" * 40 + "\n"),
    "no separators": lambda text: text.replace(SEPARATOR, "\n"),
    "blank lines": lambda text: text.replace(SEPARATOR, "\n\n" + SEPARATOR + "\n"),
    "no spaces": lambda text: text.replace("MSG: ", "MSG:"),
    "no MSG": lambda text: text.replace("MSG: ", ""),
    "ROS 2": lambda text: re.sub(r"MSG: (\w+)/", r"MSG: \1/msg/", text),
    "DOS": lambda text: text.replace("\n", "\r\n"),
    "old Mac": lambda text: text.replace("\n", "\r"),
    "tabs": lambda text: text.replace(" ", "\t"),
    "indented": lambda text: re.sub("^", "   ", text, flags=re.MULTILINE),
    "installed types are missing": lambda text: SEPARATOR.join(text.split(SEPARATOR)[:2]),
    "cut in an installed type": lambda text: text[: text.index("Quaternion orien") + 5],
    "an installed type is garbled": lambda text: text.replace("Point position", "Po%nt [posi"),
}


@pytest.mark.parametrize("kind", READABLE)
def test_own_types_are_read_if_their_md5_comes_out(kind: str) -> None:
    text = READABLE[kind](OWN._full_text)
    cls: Any = find_class(OWN._type, OWN._md5sum, text)
    assert (cls._type, cls._md5sum, cls._slot_types, cls.LIMIT) == (OWN._type, OWN._md5sum, OWN._slot_types, 3)
    assert from_definition(cls._type, cls._full_text)._md5sum == OWN._md5sum
    if kind not in ("no MSG", "cut in an installed type", "an installed type is garbled"):
        assert find_class(OWN._type, "*", text).__slots__ == OWN.__slots__


def test_a_garbled_text_of_another_version_of_an_installed_type_is_read() -> None:
    text = POSE._full_text.replace("Pose pose", "Pose pose\nfloat64 weight", 1)
    md5sum = from_definition(POSE._type, text)._md5sum
    assert find_class(POSE._type, md5sum, text.replace("Point position", "Po%nt [posi")).__slots__[-1] == "weight"


@pytest.mark.parametrize("md5sum", [POSE._md5sum, POSE._md5sum.upper(), f" {POSE._md5sum}\n", "*", ""])
@pytest.mark.parametrize("prefer_installed", [False, True])
def test_installed_types_take_the_place_of_any_text(md5sum: str, prefer_installed: bool) -> None:
    rng, whole = random.Random(1), POSE._full_text
    cut = [whole[:size] for size in rng.sample(range(len(whole)), 20)]
    for text in ("", " \n", "# empty", "%%%", "Header header\nPose pose", "x" * (MAX_TEXT_LENGTH + 1), *cut):
        cls = find_class(POSE._type, md5sum, text, prefer_installed=prefer_installed)
        assert (cls.__slots__, cls._slot_types, cls._md5sum) == (POSE.__slots__, POSE._slot_types, POSE._md5sum), text


def test_what_is_not_known_by_its_md5() -> None:
    """In bags the text counts, for tools the installed type; without either there is an error."""
    wrong = "0" * 32
    assert find_class("std_msgs/Int32", wrong, "int8 x")._slot_types == ["int8"]
    assert find_class("std_msgs/Int32", "*", "int8 x")._slot_types == ["int8"]
    assert find_class("std_msgs/Int32", wrong, "int8 x", prefer_installed=True)._slot_types == ["int32"]
    assert find_class("std_msgs/Int32", wrong, "", prefer_installed=True)._slot_types == ["int32"]
    newer = from_definition("std_msgs/Int32", "int8 x")
    assert find_class("std_msgs/Int32", newer._md5sum, "int8 x", prefer_installed=True)._md5sum == newer._md5sum
    with pytest.raises(UnknownTypeError, match="sent no definition, and the installed one has another md5"):
        find_class("std_msgs/Int32", wrong, "")
    with pytest.raises(UnknownTypeError, match=r"own_msgs/Robot sent no definition$"):
        find_class("own_msgs/Robot", wrong, " ", prefer_installed=True)
    with pytest.raises(DefinitionError, match="uses own_msgs/Part, but its text is missing"):
        find_class("own_msgs/Robot", wrong, "Part part", prefer_installed=True)
    with pytest.raises(DefinitionError, match="is not a type name"):
        find_class("Robot", "*", "int8 x")


def test_other_connections_of_the_type_help() -> None:
    for text in ("", "Part part", "%"):
        with pytest.raises((DefinitionError, UnknownTypeError)):
            DefinitionCache().get(OWN._type, OWN._md5sum, text)
        cls = DefinitionCache().get(OWN._type, OWN._md5sum, text, ["int8 x", OWN._full_text])
        assert cls._md5sum == OWN._md5sum


def test_a_received_message_of_an_installed_type_needs_no_text() -> None:
    body = b"\5\0\0\0"
    for header in (
        {"type": "std_msgs/Int32", "md5sum": load_message("std_msgs/Int32")._md5sum},
        {"type": "std_msgs/Int32", "message_definition": "int"},
        {"type": "std_msgs/Int32", "md5sum": "0" * 32, "message_definition": "int8 x"},
    ):
        message: Any = AnyMsg(body + b"behind", header).decode()
        assert message.data == 5


def test_a_long_line_of_blanks_takes_no_time() -> None:
    text = "int32 a\n" + " " * (MAX_TEXT_LENGTH // 2) + "!"
    with pytest.raises(DefinitionError):
        find_class("own_msgs/Blank", "0" * 32, text)


def test_a_cache_searches_once_in_vain(monkeypatch: pytest.MonkeyPatch) -> None:
    searches: list[str] = []

    def search(name: str, *args: Any, **keywords: Any) -> Any:
        searches.append(name)
        return find_class(name, *args, **keywords)

    monkeypatch.setattr("pyros1.msgs.nonstandard_definitions.find_class", search)
    cache = DefinitionCache()
    for _ in range(3):
        with pytest.raises(DefinitionError, match="garbled") as caught:
            cache.get(OWN._type, OWN._md5sum, "garb%led Wo[rd garbled")
        assert len(caught.traceback) == 2
    assert len(searches) == 1
    assert cache.get(OWN._type, OWN._md5sum, "garb%led Wo[rd garbled", [OWN._full_text])._md5sum == OWN._md5sum
    assert cache.get(OWN._type, OWN._md5sum, "garb%led Wo[rd garbled")._md5sum == OWN._md5sum


def test_classes_that_are_cached() -> None:
    cache = DefinitionCache()
    known, garbled = (OWN._type, OWN._md5sum, OWN._full_text), (OWN._type, OWN._md5sum, "garb%led")
    assert cache.get_cached(*known) is None
    with pytest.raises(DefinitionError):
        cache.get(*garbled)
    assert cache.get_cached(*garbled) is None
    assert cache.get_cached(*known) is None
    assert cache.get(*known) is cache.get_cached(*known)


def test_unknown_nested_types_are_not_compared_with_all_that_are_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    # A peer decides on the number of names, and to look for similar ones takes milliseconds for each.
    compared: list[str] = []
    monkeypatch.setattr("pyros1.finding.library.did_you_mean", lambda word, known: compared.append(word) or "")
    names = [f"nopkg_{number}/Part" for number in range(50)]
    text = "string name\n" + "".join(f"{SEPARATOR}MSG: {name}\nint32 a\n" for name in names)
    cls: Any = find_class("own_msgs/Robot", "0" * 32, text)
    assert cls.__slots__ == ["name"]
    with pytest.raises(DefinitionError, match="its text is missing"):
        find_class("own_msgs/Robot", "0" * 32, "".join(f"{name} a{at}\n" for at, name in enumerate(names)))
    assert compared == []


@pytest.mark.parametrize("title", ["a/B\u00e9", "_msgs/X", "a/10"])
def test_a_title_that_names_no_type_is_an_error(title: str) -> None:
    with pytest.raises(DefinitionError):
        find_class("own_msgs/X", "0" * 32, f"MSG: {title}\nint8 x")
