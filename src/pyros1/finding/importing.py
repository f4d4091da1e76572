"""Generates modules from definitions on import, as in ``from pyros1.msgs.std_msgs.msg import Float64``.

`pyros1.ground.msgs_imports` requests ``pyros1.msgs.<package>``, ``.msg`` and ``.srv``. A class is created when it is
first used and then stored in its module, so that each type has one class per process, which pickle can find.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from types import ModuleType
from typing import Any

from pyros1.finding.library import Library
from pyros1.ground.errors import UnknownTypeError
from pyros1.ground.msgs_imports import MSGS_PACKAGE, module_name, package_name
from pyros1.msgs.base import Message, Service
from pyros1.msgs.factory import make_message_class, make_service_class
from pyros1.msgs.spec import is_type_name


class MessageFinder:
    """Finds definitions by name, and creates message and service classes and their modules.

    Args:
        environ: environment variables, which are read when the first definition is needed.

    Attributes:
        uses_stock_names: whether classes have the ``__module__`` set by the stock generator: ``std_msgs.msg._String``.
            True in programs written for stock ROS: some of them read the package's name from ``__module__``, and stock
            ROS can read their pickles.
    """

    def __init__(self, environ: Mapping[str, str]) -> None:
        self._environ = environ
        self._library: Any = None
        self.uses_stock_names = False

    @property
    def library(self) -> Any:
        """The :class:`pyros1.finding.library.Library` that provides the definitions."""
        if self._library is None:
            self._library = Library(self._environ)
        return self._library

    # -- modules -------------------------------------------------------------------------------------------------------

    def check(self, name: str) -> None:
        """Check that a module can be created.

        Args:
            name: full name of a package, of its msg or srv module, or of a type in one of these modules. Python
                imports a type like a module only if the msg or srv module has no such attribute.

        Raises:
            ImportError: there is no such package or type; the message suggests a similar name.
        """
        module, *kind = name[len(MSGS_PACKAGE) + 1 :].split(".")
        package = package_name(module)
        if not self.library.has_package(package):
            message = f"No module named {name!r}: {self.library.missing_package_message(package)}"
            raise ModuleNotFoundError(message, name=name)
        match kind:
            case ["msg" | "srv" as part, short_name]:
                raise ImportError(self._import_problem(f"{package}/{short_name}", part), name=name)

    def fill(self, module: ModuleType) -> None:
        """Initialise a new module: msg and srv modules create each class when it is first used."""
        package, *kinds = module.__name__[len(MSGS_PACKAGE) + 1 :].split(".")
        package = package_name(package)
        module.__doc__ = f"Definitions of the ROS package {package}."
        if not kinds:
            return
        make_class, list_names = (
            (self.message, self._message_names) if kinds == ["msg"] else (self._service_part, self._service_names)
        )

        def __getattr__(name: str) -> Any:
            if name == "__all__":
                return list_names(package)
            if name.startswith("_"):
                raise AttributeError(f"module {module.__name__} has no attribute {name}")
            try:
                return make_class(f"{package}/{name}")
            except UnknownTypeError as error:
                raise AttributeError(str(error)) from error

        vars(module)["__getattr__"] = __getattr__
        vars(module)["__dir__"] = lambda: list_names(package)

    def _import_problem(self, name: str, kind: str) -> str:
        """Return the reason why a type cannot be imported from a msg or srv module."""
        make_class, other_names, other_kind = (
            (self.message, self.library.services, "srv")
            if kind == "msg"
            else (self.service, self.library.messages, "msg")
        )
        package, _, short_name = name.partition("/")
        try:
            make_class(name)
        except UnknownTypeError as error:
            if short_name in other_names(package):
                return f"{error}; did you mean {MSGS_PACKAGE}.{module_name(package)}.{other_kind}.{short_name}?"
            return str(error)
        return (
            f"{short_name} is a class, not a module: write "
            f"from {MSGS_PACKAGE}.{module_name(package)}.{kind} import {short_name}"
        )

    # -- classes -------------------------------------------------------------------------------------------------------

    def message(self, name: str) -> type[Message]:
        """Return the class of a message type.

        Raises:
            UnknownTypeError: no definition was found.
            DefinitionError: the definition is invalid.
        """

        def make(module: str) -> type[Message]:
            module_of_class = self._class_module(name, "msg", module)
            return make_message_class(self.library.message(name), self.library.digests, self.message, module_of_class)

        return self._cached_class(name, "msg", make)  # type: ignore[no-any-return]  # the type that make returns

    def service(self, name: str) -> type[Service]:
        """Return the class of a service type; raises the same errors as :meth:`message`."""

        def make(module: str) -> type[Service]:
            module_of_class = self._class_module(name, "srv", module)
            return make_service_class(self.library.service(name), self.library.digests, self.message, module_of_class)

        return self._cached_class(name, "srv", make)  # type: ignore[no-any-return]  # the type that make returns

    def _class_module(self, name: str, kind: str, module: str) -> str:
        package, _, short_name = name.partition("/")
        return f"{package}.{kind}._{short_name}" if self.uses_stock_names else module

    def _service_part(self, name: str) -> type[Any]:
        """Return the class with the given name in a srv module: a service, or the request or response of a service."""
        short_name = name.partition("/")[2]
        if short_name not in self.library.services(name.partition("/")[0]):
            for part, attribute in (("Request", "_request_class"), ("Response", "_response_class")):
                if short_name.endswith(part):
                    service = self.service(name.removesuffix(part))
                    return self._cached_class(name, "srv", lambda _: getattr(service, attribute))  # type: ignore[no-any-return]  # noqa: B023  called at once
        return self.service(name)

    def _cached_class(self, name: str, kind: str, make: Callable[[str], type[Any]]) -> Any:
        package, _, short_name = name.partition("/")
        if not is_type_name(name) or not self.library.has_package(package):
            # Raises an error with a suggestion.
            return self.library.message(name) if kind == "msg" else self.library.service(name)
        module = importlib.import_module(f"{MSGS_PACKAGE}.{module_name(package)}.{kind}")
        cached = vars(module).get(short_name)
        if cached is None:
            # Another thread may have created the class in the meantime; the class stored first is kept.
            cached = vars(module).setdefault(short_name, make(module.__name__))
        return cached

    def _message_names(self, package: str) -> list[str]:
        names: list[str] = self.library.messages(package)
        return names

    def _service_names(self, package: str) -> list[str]:
        return [name + part for name in self.library.services(package) for part in ("", "Request", "Response")]
