"""Converts messages from old bags to current definitions (L139, L140), with rules from files where necessary.

A rule file (.bmr) is a Python program given by the user; it is executed, as in stock ROS. It defines subclasses of
`MessageUpdateRule`. Each subclass converts messages from an old definition to a newer definition.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable, Iterable
from typing import Any, ClassVar

from pyros1.bag.errors import BagError
from pyros1.ground.errors import MessageError
from pyros1.msgs import Message, from_definition
from pyros1.msgs.digest import SEPARATOR, split_full_text

MessageClass = type[Message]
MissingRule = tuple[MessageClass, MessageClass | None]
"""A step without a rule: from one definition to another, or to an unknown one (None)."""

_MAX_STEPS = 100


def _type_key(cls: MessageClass) -> tuple[str, str]:
    return cls._type, cls._md5sum


class MessageUpdateRule:
    """One step of a migration; rule files define subclasses.

    Args:
        migrator: converts nested messages.
        location: path of the rule file, for error messages.
    """

    old_type: ClassVar[str] = ""
    old_full_text: ClassVar[str] = ""
    new_type: ClassVar[str] = ""
    new_full_text: ClassVar[str] = ""
    order: ClassVar[int] = -1
    migrated_types: ClassVar[list[tuple[str, str]]] = []
    valid: ClassVar[bool] = False

    def __init__(self, migrator: Migrator, location: str) -> None:
        self.migrator = migrator
        self.location = location
        self.old_class = from_definition(self.old_type, self.old_full_text.strip("\n"))
        self.new_class = from_definition(self.new_type, self.new_full_text.strip("\n"))

    def update(self, old_msg: Any, new_msg: Any) -> None:
        """Fill a new message from an old message."""
        raise NotImplementedError(f"{self.location}: the rule for {self.old_type} has no update()")

    def get_new_class(self, name: str) -> MessageClass:
        """Return the class of the new definition, or of a type that it uses.

        Args:
            name: name of the type; the package can be omitted if it is the definition's own package.

        Raises:
            KeyError: the definition uses no such type.
        """
        return self._find_class(self.new_class, name)

    def get_old_class(self, name: str) -> MessageClass:
        """Return the class of the old definition, or of a type that it uses; see `get_new_class`."""
        return self._find_class(self.old_class, name)

    def _find_class(self, cls: MessageClass, name: str) -> MessageClass:
        full_name = name if "/" in name else f"{'std_msgs' if name == 'Header' else cls._type.partition('/')[0]}/{name}"
        if full_name == cls._type:
            return cls
        if full_name not in split_full_text(cls._type, cls._full_text) and full_name != "std_msgs/Header":
            raise KeyError(full_name)
        return self.migrator.nested_class(cls, full_name)

    def migrate(self, old_msg: Message, new_msg: Message) -> None:
        """Fill a nested message in the new message from one in the old message."""
        converted = self.migrator.convert(old_msg, type(new_msg))
        for name in new_msg.__slots__:
            setattr(new_msg, name, getattr(converted, name))

    def migrate_array(self, old_array: Iterable[Message], new_array: list[Message], new_name: str) -> None:
        """Fill an array of nested messages in the new message from one in the old message; `new_name` is the new type
        of the elements.
        """
        cls = self.get_new_class(new_name)
        new_array[:] = [self.migrator.convert(item, cls) for item in old_array]


class Migrator:
    """Converts messages, by rules or by the names of their fields.

    Args:
        load: returns the current class of a type; raises MessageError if there is none.
    """

    def __init__(self, load: Callable[[str], MessageClass]) -> None:
        self._load = load
        self.rules: dict[tuple[str, str], MessageUpdateRule] = {}
        self._nested_classes: dict[tuple[str, str, str], MessageClass] = {}

    def read_rules(self, path: str) -> None:
        """Execute a rule file, and add its rules.

        Raises:
            BagError: the file is not a Python program, or its rules are wrong.
            OSError: the file cannot be read.
        """
        with open(path, "rb") as file:
            text = file.read()
        namespace: dict[str, Any] = {"MessageUpdateRule": MessageUpdateRule}
        try:
            exec(compile(text, path, "exec"), namespace)
            for value in namespace.values():
                if isinstance(value, type) and issubclass(value, MessageUpdateRule) and value is not MessageUpdateRule:
                    rule = value(self, path)
                    self.rules[_type_key(rule.old_class)] = rule
        except Exception as error:
            raise BagError(path, f"the rules cannot be used: {type(error).__name__}: {error}") from error

    def current_class(self, old: MessageClass) -> MessageClass | None:
        """Return the current class that replaces an old one, found by rules if the type was renamed; None if there is
        none.
        """
        cls, steps = old, 0
        while (rule := self.rules.get(_type_key(cls))) is not None and steps < _MAX_STEPS:
            cls, steps = rule.new_class, steps + 1
        try:
            return self._load(cls._type)
        except MessageError:
            return None

    def missing_rules(self, old: MessageClass, new: MessageClass | None, depth: int = 0) -> list[MissingRule]:
        """Return the steps from one class to another that lack a valid rule, including steps of nested types."""
        if new is None or depth > _MAX_STEPS:
            return [(old, None)]
        if _type_key(old) == _type_key(new):
            return []
        rule = self.rules.get(_type_key(old))
        if rule is not None:
            invalid_steps: list[MissingRule] = [] if rule.valid else [(old, rule.new_class)]
            return invalid_steps + self.missing_rules(rule.new_class, new, depth + 1)
        if not _have_same_fields(old, new):
            return [(old, new)]
        steps: dict[tuple[str, str], MissingRule] = {}
        for old_name, new_name in _nested_types(old, new):
            for step in self.missing_rules(
                self.nested_class(old, old_name), self.nested_class(new, new_name), depth + 1
            ):
                steps.setdefault(_type_key(step[0]), step)
        return list(steps.values())

    def convert(self, message: Message, new: MessageClass) -> Message:
        """Return a message converted to another class.

        Raises:
            MessageError: a rule is missing.
            BagError: a rule failed.
        """
        old = type(message)
        if _type_key(old) == _type_key(new):
            encoded: Any = old._encode(message)
            data = encoded if isinstance(encoded, bytes) else b"".join(encoded)
            copy: Message = new._decode(data, 0, len(data))
            return copy
        rule = self.rules.get(_type_key(old))
        if rule is not None:
            result = rule.new_class()
            try:
                rule.update(message, result)
            except (MessageError, BagError):
                raise
            except Exception as error:
                reason = f"the rule for {rule.old_type} failed: {type(error).__name__}: {error}"
                raise BagError(rule.location, reason) from error
            return self.convert(result, new)
        if not _have_same_fields(old, new):
            raise MessageError(
                f"there is no rule to convert {old._type} [{old._md5sum}] to {new._type} [{new._md5sum}]"
            )
        result = new()
        for name, type_name in zip(new.__slots__, new._slot_types, strict=True):
            value = getattr(message, name)
            if "/" in type_name:
                nested_class = self.nested_class(new, type_name.partition("[")[0])
                is_array = "[" in type_name
                value = (
                    [self.convert(item, nested_class) for item in value]
                    if is_array
                    else self.convert(value, nested_class)
                )
            setattr(result, name, value)
        return result

    def nested_class(self, cls: MessageClass, name: str) -> MessageClass:
        """Return the class of a type that another class uses; `name` is the type's name."""
        key = (*_type_key(cls), name)
        if key not in self._nested_classes:
            texts = split_full_text(cls._type, cls._full_text)
            definition = texts.pop(name, "")
            if not definition and name == "std_msgs/Header":
                definition = "uint32 seq\ntime stamp\nstring frame_id"
            used_definitions = [
                f"{SEPARATOR}\nMSG: {other}\n{text}" for other, text in texts.items() if other != cls._type
            ]
            self._nested_classes[key] = from_definition(name, "\n".join([definition, *used_definitions]))
        return self._nested_classes[key]


def _have_same_fields(old: MessageClass, new: MessageClass) -> bool:
    """Return whether two classes have the same fields; constants, and definitions of the types used, may differ."""
    fields = [
        [
            (name, type_name if "/" not in type_name else type_name.partition("[")[1:])
            for name, type_name in zip(*names_and_types, strict=True)
        ]
        for names_and_types in ((old.__slots__, old._slot_types), (new.__slots__, new._slot_types))
    ]
    return old._type == new._type and fields[0] == fields[1]


def _nested_types(old: MessageClass, new: MessageClass) -> list[tuple[str, str]]:
    pairs = zip(old._slot_types, new._slot_types, strict=True)
    return [(old_type.partition("[")[0], new_type.partition("[")[0]) for old_type, new_type in pairs if "/" in old_type]


def _string_literal(text: str) -> str:
    """Return a triple-quoted Python literal for a string, so that no text from a bag can become code."""
    escaped = text.replace("\\", "\\\\").replace("\r", "\\r").replace('"""', '\\"\\"\\"')
    # Python source must not contain NUL, or surrogates. These stand for bytes that are not UTF-8, for example in the
    # comments of old .msg files.
    escaped = re.sub("[\0\ud800-\udfff]", lambda match: f"\\u{ord(match[0]):04x}", escaped)
    return f'"""\n{escaped}\n"""'


def rule_text(old: MessageClass, new: MessageClass, order: int = 0) -> str:
    """Return the source of a rule for the user to complete; it copies fields with the same name and type."""
    old_types = dict(zip(old.__slots__, old._slot_types, strict=True))
    body = []
    for name, type_name in zip(new.__slots__, new._slot_types, strict=True):
        element_type, bracket, _ = type_name.partition("[")
        if name not in old_types:
            body.append(f"# the old message has no {type_name} {name}: new_msg.{name} = ...")
        elif "/" in type_name and bracket:
            body.append(f"self.migrate_array(old_msg.{name}, new_msg.{name}, {element_type!r})")
        elif "/" in type_name:
            body.append(f"self.migrate(old_msg.{name}, new_msg.{name})")
        else:
            comment = "" if old_types[name] == type_name else f"  # was {old_types[name]}, is {type_name}"
            body.append(f"new_msg.{name} = old_msg.{name}{comment}")
    body += [f"# the new message has no field {name}" for name in old_types if name not in new.__slots__]
    if all(line.startswith("#") for line in body):
        body.append("pass")
    class_name = f"update_{old._type.replace('/', '_')}_{old._md5sum}"
    parts = [
        f"class {class_name}(MessageUpdateRule):",
        f'    old_type = "{old._type}"',
        f"    old_full_text = {_string_literal(old._full_text)}",
        f'    new_type = "{new._type}"',
        f"    new_full_text = {_string_literal(new._full_text)}",
        f"    order = {order}",
        "    migrated_types = []",
        "    valid = False  # set this to True when update() is complete",
        "",
        "    def update(self, old_msg, new_msg):",
        textwrap.indent("\n".join(body), "        "),
    ]
    return "\n".join(parts) + "\n\n"
