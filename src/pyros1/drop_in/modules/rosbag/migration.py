"""Converts old bags to this system's definitions (https://wiki.ros.org/rosbag/migration)."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any, NamedTuple

from pyros1.bag.api import Bag
from pyros1.bag.edit.migrate import MigratedBagWriter, find_migrations
from pyros1.bag.edit.migration import MessageUpdateRule as _MessageUpdateRule
from pyros1.bag.edit.migration import Migrator, rule_text
from pyros1.drop_in.module_attributes import module_getattr
from pyros1.msgs import load_message

__getattr__ = module_getattr(
    __name__,
    RuleChain="pyros1 plans migrations differently; see pyros1.bag.edit.migration",
    ScaffoldNode="pyros1 plans migrations differently; see pyros1.bag.edit.migration",
)


_BUILTIN_TYPES = frozenset([
    "int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64", "float32", "float64", "bool", "char",
    "byte", "string", "time", "duration",
])  # fmt: skip


class BagMigrationException(Exception):
    """A bag cannot be converted."""


class Step(NamedTuple):
    """A conversion that is needed.

    Attributes:
        old_class: the class of the old definition.
        new_class: this system's class of the type; None if this system does not have the type.
    """

    old_class: Any
    new_class: Any


class MessageMigrator(Migrator):
    """Converts messages by rules.

    Args:
        input_rule_files: paths of rule files (.bmr).
        plugins: accepted for compatibility; the caller also passes the rule files of packages.
    """

    def __init__(self, input_rule_files: Sequence[str] = [], plugins: bool = True) -> None:
        super().__init__(load_message)
        for path in input_rule_files:
            self.read_rules(path)

    def lookup_type(self, key: tuple[str, str]) -> Any:
        """Return the class that a rule defines for a type and an md5 sum; None if no rule does."""
        for rule in self.rules.values():
            for cls in (rule.old_class, rule.new_class):
                if get_message_key(cls) == key:
                    return cls
        return None

    def all_rules_valid(self) -> bool:
        """Return whether all rules can be used; invalid rules in files are already rejected when the files are read."""
        return not self.get_invalid_rules()

    def get_invalid_rules(self) -> list[Any]:
        """Return the rules that cannot be used."""
        return [rule for rule in self.rules.values() if not rule.valid]

    def add_update_rule(self, r: Any) -> None:
        """Add a rule."""
        self.rules[get_message_key(r.old_class)] = r

    def filter_rules_unique(self, rules: Any) -> list[Any]:
        """Return rules without duplicates."""
        unique = {
            (get_message_key(rule.old_class), rule.new_class and get_message_key(rule.new_class)): rule
            for rule in rules
        }
        return list(unique.values())

    def expand_rules(self, rules: Any) -> list[Any]:
        """Return rules, each followed by the rules that it needs, without duplicates."""
        return self.filter_rules_unique(
            [expanded_rule for rule in rules for expanded_rule in (rule, *self.expand_rules(rule.sub_rules))]
        )

    def make_update_rule(self, old_class: Any, new_class: Any) -> type[MessageUpdateRule]:
        """Return the class of a rule between two message classes; the rule must be completed by hand."""
        name = f"update_{old_class._type.replace('/', '_')}_{old_class._md5sum}"
        return type(name, (MessageUpdateRule,), {"old_class": old_class, "new_class": new_class})

    def find_target(self, old_class: Any) -> Any:
        """Return this system's class of a type; None if there is none."""
        return self.current_class(old_class)

    def migrate(self, msg_from: Any, msg_to: Any) -> None:
        """Fill a message from a message with an older definition.

        Raises:
            BagMigrationException: rules are missing.
        """
        missing_steps = self.missing_rules(type(msg_from), type(msg_to))
        if missing_steps:
            raise BagMigrationException(
                f"Migrate called, but no valid migration path from [{msg_from._type}] to [{msg_to._type}]"
            )
        converted = self.convert(msg_from, type(msg_to))
        for name in msg_to.__slots__:
            setattr(msg_to, name, getattr(converted, name))

    def migrate_array(self, msg_from_array: Any, msg_to_array: Any) -> None:
        """Fill the messages in a list from another list of the same length; raise the same errors as `migrate`."""
        if len(msg_from_array) != len(msg_to_array):
            raise BagMigrationException("Migrate array called on on arrays of unequal length.")
        for old, new in zip(msg_from_array, msg_to_array, strict=True):
            self.migrate(old, new)

    def migrate_raw(self, msg_from: Any, msg_to: Any) -> tuple[Any, ...]:
        """Convert a raw message.

        Args:
            msg_from: tuple of type, bytes, md5 sum, position and class, as `Bag.read_messages` yields it.
            msg_to: a tuple of the same form, with the class of the result.
        """
        old = msg_from[4]().deserialize(msg_from[1])
        new = msg_to[4]()
        self.migrate(old, new)
        buffer = io.BytesIO()
        new.serialize(buffer)
        return (new._type, buffer.getvalue(), new._md5sum, msg_to[3], type(new))


class MessageUpdateRule(_MessageUpdateRule):
    """One step of a migration; rule files derive from it.

    Args:
        migrator: converts the fields.
        location: the file, for error messages.
    """

    def __init__(self, migrator: Any, location: Any) -> None:
        self.migrator = migrator
        self.location = location
        self.sub_rules: list[Any] = []
        """Rules that this rule needs."""
        if self.old_type or self.new_type:
            super().__init__(migrator, location)

    def find_sub_paths(self) -> None:
        """Find the rules that are missing for nested messages."""
        self.sub_rules = []
        old, new = self.old_class, self.new_class
        if new is None:
            return
        old_types = dict(zip(old.__slots__, old._slot_types, strict=True))
        for name, slot_type in zip(new.__slots__, new._slot_types, strict=True):
            base_types = old_types.get(name, "").partition("[")[0], slot_type.partition("[")[0]
            if all("/" in type_name for type_name in base_types):
                steps = self.migrator.missing_rules(
                    self.migrator.nested_class(old, base_types[0]), self.migrator.nested_class(new, base_types[1])
                )
                self.sub_rules += [_missing_rule(self.migrator, *step) for step in steps]

    def get_class_def(self) -> str:
        """Return the code of a rule that must be completed by hand."""
        return rule_text(self.old_class, self.new_class, max(self.order, 0))

    def apply(self, old_msg: Any) -> Any:
        """Return a new message, converted from an old one; raise BagMigrationException if the rule is not valid."""
        if not self.valid:
            raise BagMigrationException("Attempted to apply an invalid rule")
        message = self.new_class()
        self.update(old_msg, message)
        return message


def get_message_key(c: Any) -> tuple[str, str]:
    """Return the type and the md5 sum of a message class, as a key."""
    return c._type, c._md5sum


def get_path_key(c1: Any, c2: Any) -> tuple[tuple[str, str], tuple[str, str]]:
    """Return the keys of an old and a new message class."""
    return get_message_key(c1), get_message_key(c2)


def qualified_name(name: str, top_name: str) -> str:
    """Return a type's full name. If it has no package, use the package of ``top_name``, or std_msgs for Header."""
    if "/" in name or name.partition("[")[0] in _BUILTIN_TYPES:
        return name
    return "std_msgs/Header" if name == "Header" else f"{top_name.partition('/')[0]}/{name}"


def clean_name(name: str, top_name: str) -> str:
    """Return a type's name, without its package if ``top_name`` has the same one or the type is std_msgs/Header."""
    package, _, bare = name.rpartition("/")
    return bare if package == top_name.partition("/")[0] or name == "std_msgs/Header" else name


def constants_from_def(core_type: str, msg_def: str) -> set[tuple[str, Any, str]]:
    """Return name, value and type of the constants in a definition.

    Args:
        core_type: the message's type.
        msg_def: the type's definition, without the definitions of nested types.

    Raises:
        genmsg.InvalidMsgSpec: the definition is invalid.
    """
    from genmsg import MsgContext
    from genmsg.msg_loader import load_msg_from_string

    constants = load_msg_from_string(MsgContext.create_default(), msg_def, core_type).constants
    return {(constant.name, constant.val, constant.type) for constant in constants}


def migration_default_value(field_type: str) -> str:
    """Return Python code for the default value of a type, as used in generated rules."""
    base, array, count = field_type.rstrip("]").partition("[")
    if base in _BUILTIN_TYPES:
        value = "''" if base == "string" else "0." if base.startswith("float") else "0"
    if base not in _BUILTIN_TYPES or base in ("time", "duration"):
        value = f"self.get_new_class('{base}')()"
    if not array:
        return value
    if base in ("byte", "uint8"):
        return f"chr(0)*{count}" if count else "''"
    return f"[{','.join([value] * int(count or 0))}]"


def checkmessages(migrator: Any, messages: Any) -> list[Any]:
    """Do the same as `checkbag`, for a list of messages or message classes."""
    findings, checked_keys = [], set()
    for old in messages:
        if get_message_key(old) in checked_keys:
            continue
        checked_keys.add(get_message_key(old))
        cls = old if isinstance(old, type) else type(old)
        new = migrator.current_class(cls)
        if new is None or get_message_key(cls) != get_message_key(new):
            findings.append(_make_finding(migrator, cls, new, migrator.missing_rules(cls, new)))
    return findings


def checkbag(migrator: Any, inbag: str) -> list[Any]:
    """Return a pair for each type whose definition in a bag differs from this system's.

    A pair contains a list with the type's `Step`, and a list of the missing rules (`MessageUpdateRule`). If the second
    list is empty, the type can be converted.
    """
    with Bag(inbag) as bag:
        return [_make_finding(migrator, old, new, steps) for old, new, steps in find_migrations(bag, migrator)]


def _make_finding(migrator: Any, old: Any, new: Any, steps: Any) -> tuple[list[Step], list[Any]]:
    return [Step(old, new)], [_missing_rule(migrator, *step) for step in steps]


def _missing_rule(migrator: Any, old: Any, new: Any) -> Any:
    rule = migrator.make_update_rule(old, new)(migrator, "GENERATED")
    rule.find_sub_paths()
    return rule


def fixbag(migrator: Any, inbag: str, outbag: str) -> bool:
    """Write a bag with converted messages; return False, and write nothing, if rules are missing."""
    return not fixbag2(migrator, inbag, outbag)


def fixbag2(migrator: Any, inbag: str, outbag: str, force: bool = False) -> list[Any]:
    """Write a bag with converted messages.

    Args:
        force: whether to copy messages unchanged if rules are missing for them.

    Returns:
        The differences found by `checkbag` for which rules are missing; an empty list if the bag was written.
    """
    unconverted = [finding for finding in checkbag(migrator, inbag) if finding[1]]
    if unconverted and not force:
        return unconverted
    with Bag(inbag) as bag:
        MigratedBagWriter(bag, migrator).write(outbag, lambda done: None)
    return []
