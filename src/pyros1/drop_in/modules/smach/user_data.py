"""Data that states pass to each other (https://wiki.ros.org/smach/Tutorials/User%20Data)."""

from __future__ import annotations

import threading
from collections.abc import Iterable, Mapping
from typing import Any

from smach.const import get_const
from smach.exceptions import InvalidUserCodeError
from smach.log import logerr


class MissingKey(KeyError, AttributeError):
    """A key has no value yet."""


class UserData:
    """Values by name, as attributes or items: ``userdata.count`` is ``userdata["count"]``.

    A name without a value raises `MissingKey`, which is a KeyError and an AttributeError.
    """

    def __init__(self) -> None:
        vars(self)["_data"] = {}
        vars(self)["_lock"] = threading.Lock()

    def update(self, other_userdata: UserData) -> None:
        """Copy all values from another UserData object."""
        with self._lock:
            self._data.update({key: other_userdata[key] for key in other_userdata.keys()})  # noqa: SIM118

    def extract(self, keys: Iterable[str], remapping: Mapping[str, str]) -> UserData:
        """Return a new UserData object with some of the values.

        Args:
            keys: names in this object.
            remapping: name in the new object -> name in this object, if they differ.
        """
        new_names = {here: name for name, here in remapping.items()}
        if len(new_names) != len(remapping):
            logerr(f"SMACH userdata remapping is not one-to-one: {remapping}")
        result = UserData()
        for key in keys:
            result[new_names.get(key, key)] = self[key]
        return result

    def merge(self, ud: UserData, keys: Iterable[str], remapping: Mapping[str, str]) -> None:
        """Copy some of the values from another UserData object.

        Args:
            ud: the other object.
            keys: names in ``ud``.
            remapping: name in ``ud`` -> name in this object, if they differ.
        """
        for key in keys:
            self[remapping.get(key, key)] = ud[key]

    def keys(self) -> list[str]:
        """Return the names that have values."""
        return list(self._data)

    def __contains__(self, key: object) -> bool:
        return key in self._data

    def __getitem__(self, key: str) -> Any:
        try:
            return self._data[key]
        except KeyError:
            raise MissingKey(key) from None

    def __setitem__(self, key: str, item: Any) -> None:
        with self._lock:
            self._data[key] = item

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        return self[name]

    def __setattr__(self, name: str, value: Any) -> None:
        if name.startswith("_"):
            object.__setattr__(self, name, value)
        else:
            self[name] = value

    def __getstate__(self) -> dict[str, Any]:
        return {"_data": self._data}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state, _lock=threading.Lock())


class Remapper:
    """A state's view of its container's userdata: the keys that the state declares, under the state's own names.

    Reading a key that is not an input, or writing one that is not an output, raises InvalidUserCodeError. An object
    that is only an input cannot be changed: see `smach.const`.

    Args:
        ud: the container's userdata, or another view.
        input_keys, output_keys: the keys that the state declares.
        remapping: name in the state -> name in ``ud``, if they differ.
    """

    def __init__(
        self,
        ud: Any,
        input_keys: Iterable[str] = (),
        output_keys: Iterable[str] = (),
        remapping: Mapping[str, str] | None = None,
    ) -> None:
        vars(self).update(
            _ud=ud, _input_keys=tuple(input_keys), _output_keys=tuple(output_keys), _remapping=dict(remapping or {})
        )

    def _remap(self, key: str) -> str:
        return self._remapping.get(key, key)

    def keys(self) -> list[str]:
        """Return the inputs that have values."""
        return [key for key in self._input_keys if key in self]

    def update(self, other_userdata: Any) -> None:
        """Copy all values from another UserData object; each name must be an output."""
        for key in other_userdata.keys():  # noqa: SIM118  userdata is not a mapping
            self[key] = other_userdata[key]

    def __contains__(self, key: object) -> bool:
        return isinstance(key, str) and key in self._input_keys and self._remap(key) in self._ud

    def __getitem__(self, key: str) -> Any:
        if key not in self._input_keys:
            raise InvalidUserCodeError(
                f"Reading from SMACH userdata key '{key}' but the only keys that were declared as input to this state "
                f"were: {self._input_keys}. This key needs to be declared as input to this state. "
            )
        value = self._ud[self._remap(key)]
        return value if key in self._output_keys else get_const(value)

    def __setitem__(self, key: str, value: Any) -> None:
        if key not in self._output_keys:
            raise InvalidUserCodeError(
                f"Writing to SMACH userdata key '{key}' but the only keys that were declared as output from this state "
                f"were: {self._output_keys}."
            )
        self._ud[self._remap(key)] = value

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        return self[name]

    def __setattr__(self, name: str, value: Any) -> None:
        if name.startswith("_"):
            object.__setattr__(self, name, value)
        else:
            self[name] = value


__all__ = ["Remapper", "UserData"]
