"""Loads definitions, and the definitions that they use, from files."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any

from genmsg.base import COMMENTCHAR, CONSTCHAR, EXT_MSG, EXT_SRV, IODELIM, SEP, InvalidMsgSpec, log
from genmsg.msgs import (
    DURATION,
    DURATION_MSG,
    HEADER,
    HEADER_FULL_NAME,
    TIME,
    TIME_MSG,
    Constant,
    Field,
    MsgSpec,
    bare_msg_type,
    is_builtin,
    is_valid_constant_type,
    is_valid_msg_field_name,
    is_valid_msg_type,
    resolve_type,
)
from genmsg.names import normalize_package_context, package_resource_name
from genmsg.srvs import SrvSpec
from pyros1.drop_in.module_attributes import module_getattr
from pyros1.ground.errors import DefinitionError
from pyros1.msgs import spec as _spec

SearchPath = Mapping[str, Sequence[str]]
"""Package -> folders of its definitions."""

__getattr__ = module_getattr(__name__)


class MsgNotFound(Exception):
    """A definition's file does not exist."""

    def __init__(
        self,
        message: str,
        base_type: str | None = None,
        package: str | None = None,
        search_path: SearchPath | None = None,
    ) -> None:
        super().__init__(message)
        self.base_type = base_type
        self.package = package
        self.search_path = search_path


class MsgContext:
    """Definitions by full name, with their files and the types that they use."""

    def __init__(self) -> None:
        self._registered: dict[str, MsgSpec] = {}
        self._files: dict[str, str] = {}
        self._dependencies: dict[str, list[str] | None] = {}

    @staticmethod
    def create_default() -> MsgContext:
        """Return a new context with the built-in types that have fields: time and duration."""
        context = MsgContext()
        for full_name, text in ((TIME, TIME_MSG), (DURATION, DURATION_MSG)):
            rows = [line.split() for line in text.split("\n")]
            types, names = [type_name for type_name, _ in rows], [name for _, name in rows]
            context.register(full_name, MsgSpec(types, names, [], text, full_name))
        return context

    def register(self, full_msg_type: str, msgspec: MsgSpec) -> None:
        """Register a definition."""
        self._registered[full_msg_type.partition("[")[0]] = msgspec

    def is_registered(self, full_msg_type: str) -> bool:
        """Return whether a definition is known."""
        return full_msg_type.partition("[")[0] in self._registered

    def get_registered(self, full_msg_type: str) -> MsgSpec:
        """Return a definition; raises KeyError if it is not known."""
        if not self.is_registered(full_msg_type):
            raise KeyError(full_msg_type)
        return self._registered[full_msg_type.partition("[")[0]]

    def set_file(self, full_msg_type: str, file_path: str) -> None:
        """Record the path of a definition's file."""
        self._files[full_msg_type] = file_path

    def get_file(self, full_msg_type: str) -> str | None:
        """Return the path of a definition's file; None if it is not known."""
        return self._files.get(full_msg_type)

    def set_depends(self, full_msg_type: str, dependencies: list[str] | None) -> None:
        """Record the names of the types that a type uses."""
        self._dependencies[full_msg_type] = dependencies

    def get_depends(self, full_msg_type: str) -> list[str] | None:
        """Return the names of the types that a type uses; None if they are not known."""
        return self._dependencies.get(full_msg_type)

    def get_all_depends(self, full_msg_type: str) -> list[str]:
        """Return the names of the types that a type uses, each followed by the names of the types that it uses itself.

        Raises:
            KeyError: it is not known which types one of these types uses.
        """
        direct = self.get_depends(full_msg_type)
        if direct is None:
            raise KeyError(full_msg_type)
        result: list[str] = []
        for name in direct:
            result += [name, *self.get_all_depends(name)]
        return result

    def __str__(self) -> str:
        return str(self._registered)


def convert_constant_value(field_type: str, val: str) -> Any:
    """Parse the value of a constant.

    Raises:
        InvalidMsgSpec: the value does not fit the type.
    """
    try:
        return _spec.parse_constant_value(field_type, val)
    except ValueError as error:
        raise InvalidMsgSpec(str(error)) from None


def load_msg_from_string(msg_context: MsgContext, text: str, full_name: str) -> MsgSpec:
    """Parse a definition and register it.

    Args:
        msg_context: where to register the definition.
        text: the definition.
        full_name: ``package/Type``.

    Raises:
        InvalidMsgSpec: the definition is invalid.
    """
    try:
        spec = message_spec(_spec.parse_message(full_name, text))
    except DefinitionError as error:
        raise InvalidMsgSpec(str(error)) from error
    msg_context.register(full_name, spec)
    return spec


def message_spec(parsed: _spec.MessageSpec) -> MsgSpec:
    """Convert a definition parsed by pyros1 to genmsg's class."""
    constants = [Constant(constant.type, constant.name, constant.value, constant.text) for constant in parsed.constants]
    types, names = [field.type for field in parsed.fields], [field.name for field in parsed.fields]
    return MsgSpec(types, names, constants, parsed.text, parsed.name)


def load_srv_from_string(msg_context: MsgContext, text: str, full_name: str) -> SrvSpec:
    """Parse a service's definition, and register both messages; see :func:`load_msg_from_string`."""
    try:
        parsed = _spec.parse_service(full_name, text)
    except DefinitionError as error:
        raise InvalidMsgSpec(str(error)) from error
    request, response = message_spec(parsed.request), message_spec(parsed.response)
    for message in (request, response):
        msg_context.register(message.full_name, message)
    return SrvSpec(request, response, text, full_name)


def _read_text(file_path: str) -> str:
    with open(file_path, encoding="utf-8") as file:
        return file.read()


def load_msg_from_file(msg_context: MsgContext, file_path: str, full_name: str) -> MsgSpec:
    """Read the definition in a file; see :func:`load_msg_from_string`. Errors contain the file's name."""
    try:
        spec = load_msg_from_string(msg_context, _read_text(file_path), full_name)
    except InvalidMsgSpec as error:
        raise InvalidMsgSpec(f"{file_path}: {error}") from error
    msg_context.set_file(full_name, file_path)
    return spec


def load_srv_from_file(msg_context: MsgContext, file_path: str, full_name: str) -> SrvSpec:
    """Read the definition of a service in a file; see :func:`load_msg_from_file`."""
    try:
        spec = load_srv_from_string(msg_context, _read_text(file_path), full_name)
    except InvalidMsgSpec as error:
        raise InvalidMsgSpec(f"{file_path}: {error}") from error
    for suffix in ("Request", "Response"):
        msg_context.set_file(full_name + suffix, file_path)
    return spec


def get_msg_file(package: str, base_type: str, search_path: SearchPath, ext: str = EXT_MSG) -> str:
    """Return the path of a definition's file.

    Raises:
        MsgNotFound: there is no such file.
        ValueError: the search path is not a mapping.
    """
    if not isinstance(search_path, Mapping):
        raise ValueError("search_path must be a dictionary of {namespace: dirpath}")
    if package not in search_path:
        text = f"Cannot locate message [{base_type}]: unknown package [{package}] on search path [{search_path}]"
        raise MsgNotFound(text, base_type, package, search_path)
    for folder in search_path[package]:
        path = os.path.join(folder, base_type + ext)
        if os.path.isfile(path):
            return path
    text = f"Cannot locate message [{base_type}] in package [{package}] with paths [{search_path[package]}]"
    raise MsgNotFound(text, base_type, package, search_path)


def get_srv_file(package: str, base_type: str, search_path: SearchPath) -> str:
    """Return the path of a service's file; see :func:`get_msg_file` for the arguments and errors."""
    return get_msg_file(package, base_type, search_path, EXT_SRV)


def load_msg_by_type(msg_context: MsgContext, msg_type: str, search_path: SearchPath) -> MsgSpec:
    """Find and read the definition of a message type; raises MsgNotFound and InvalidMsgSpec."""
    if not isinstance(search_path, Mapping):
        raise ValueError("search_path must be a dictionary of {namespace: dirpath}")
    name = HEADER_FULL_NAME if msg_type == HEADER else msg_type
    package, short = package_resource_name(name)
    return load_msg_from_file(msg_context, get_msg_file(package, short, search_path), name)


def load_srv_by_type(msg_context: MsgContext, srv_type: str, search_path: SearchPath) -> SrvSpec:
    """Find and read the definition of a service type; raises MsgNotFound and InvalidMsgSpec."""
    if not isinstance(search_path, Mapping):
        raise ValueError("search_path must be a dictionary of {namespace: dirpath}")
    package, short = package_resource_name(srv_type)
    return load_srv_from_file(msg_context, get_srv_file(package, short, search_path), srv_type)


def load_depends(msg_context: MsgContext, spec: MsgSpec | SrvSpec, msg_search_path: SearchPath) -> list[str]:
    """Read all definitions that a definition uses, directly or indirectly.

    Returns:
        The names of the types that ``spec`` uses directly.

    Raises:
        MsgNotFound: the file of one of these definitions does not exist.
        InvalidMsgSpec: one of these definitions is invalid.
        ValueError: ``spec`` has a wrong class.
    """
    if isinstance(spec, SrvSpec):
        dependencies = load_msg_depends(msg_context, spec.request, msg_search_path)
        return [*dependencies, *load_msg_depends(msg_context, spec.response, msg_search_path)]
    if not isinstance(spec, MsgSpec):
        raise ValueError(f"spec does not appear to be a message or service: {spec}")
    return load_msg_depends(msg_context, spec, msg_search_path)


def load_msg_depends(msg_context: MsgContext, spec: MsgSpec, search_path: SearchPath) -> list[str]:
    """Read all definitions that a message's definition uses; see :func:`load_depends`."""
    dependencies: list[str] = []
    msg_context.set_depends(spec.full_name, dependencies)  # before the loop, since a type may contain itself
    try:
        for field in spec.parsed_fields():
            if field.is_builtin:
                continue
            name = resolve_type(field.base_type, spec.package)
            if not msg_context.is_registered(name):
                load_msg_by_type(msg_context, name, search_path)
            if msg_context.get_depends(name) is None:
                load_msg_depends(msg_context, msg_context.get_registered(name), search_path)
            dependencies.append(name)
    except BaseException:
        msg_context.set_depends(spec.full_name, None)
        raise
    return dependencies
