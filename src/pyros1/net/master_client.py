"""Client of the ROS Master and Parameter Server API
(https://wiki.ros.org/ROS/Master_API, https://wiki.ros.org/ROS/Parameter%20Server%20API).

Some masters have fewer methods than the stock master, and different error messages. Where possible, a missing method is
replaced with others.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, cast

from pyros1.ground import terminal_text
from pyros1.ground.errors import (
    DeadlineError,
    Error,
    MasterError,
    MasterMethodError,
    MasterUnreachableError,
    ParameterNotSetError,
    ProtocolError,
    UnknownHostError,
    UnreachableError,
    XmlRpcFault,
)
from pyros1.net.hosts import DEFAULT_MASTER_URI
from pyros1.net.xmlrpc_client import XmlRpcClient

SystemState = list[list[list[Any]]]


def unpack_reply(reply: Any, responder: str) -> Any:
    """Return the value of a ``[code, message, value]`` triple.

    Args:
        reply: the triple.
        responder: the program that sent it, for error messages.

    Raises:
        MasterError: the code is not 1; the error contains the message of the triple.
        ProtocolError: the reply is not such a triple.
    """
    if not isinstance(reply, (list, tuple)) or len(reply) != 3 or not isinstance(reply[0], int):
        raise ProtocolError(f"{responder} did not reply with [code, message, value]")
    code, message, value = reply
    if code != 1:
        raise MasterError(terminal_text.one_line(message), code)
    return value


def _says_not_set(error: MasterError) -> bool:
    return error.code == -1 and "not set" in str(error)


def _is_integer(value: Any) -> bool:
    return isinstance(value, int)


def _is_string(value: Any) -> bool:
    return isinstance(value, str)


def _is_string_list(value: Any) -> bool:
    return isinstance(value, list) and all(isinstance(item, str) for item in value)


def _is_pair_list(value: Any) -> bool:
    return isinstance(value, list) and all(_is_string_list(item) and len(item) == 2 for item in value)


def is_system_state(value: Any) -> bool:
    """Return whether a value is a valid result of ``getSystemState``: three lists ``[[name, [node, ...]], ...]``."""
    return isinstance(value, list) and len(value) == 3 and all(map(_is_registration_list, value))


def _is_registration_list(value: Any) -> bool:
    return isinstance(value, list) and all(
        isinstance(entry, list) and len(entry) == 2 and isinstance(entry[0], str) and _is_string_list(entry[1])
        for entry in value
    )


def _parameter_names(namespace: str, tree: Any) -> Iterator[str]:
    """Yield the full names of the parameters in a tree, which is the value of ``namespace``."""
    if not isinstance(tree, dict) or not tree:
        yield namespace or "/"
        return
    for name, value in tree.items():
        yield from _parameter_names(f"{namespace}/{name}", value)


class MasterClient:
    """Client of a master. Thread-safe.

    Args:
        caller_id: full name of the calling node; the master resolves relative and private names against it.
        uri: the master's URI.
        timeout: maximum number of seconds for a call.

    All methods that make calls raise MasterError (the master refused), MasterMethodError (the master does not have the
    method), MasterUnreachableError (the master does not respond) and ProtocolError (its response is not valid).
    """

    def __init__(self, caller_id: str, uri: str, *, timeout: float = 10.0) -> None:
        self.caller_id = caller_id
        self.uri = uri
        try:
            self._client = XmlRpcClient(uri, timeout=timeout)
        except ProtocolError as error:
            raise ProtocolError(
                f"the master's address is wrong: {error}. Is ROS_MASTER_URI correct? For a master on this machine: "
                f"export ROS_MASTER_URI={DEFAULT_MASTER_URI}"
            ) from None
        self._closed = False
        self._lacks_multicall = False  # whether the master has no system.multicall

    def close(self) -> None:
        """Close the connection; a call pending in another thread fails immediately."""
        self._closed = True
        self._client.close()

    def call(self, method: str, *args: Any, timeout: float | None = None) -> Any:
        """Call any method with the caller id and ``args``, and return the value of the reply."""
        return unpack_reply(
            self._request(method, self.caller_id, *args, timeout=timeout), self._describe_master(method)
        )

    def _call_checked(self, is_valid: Callable[[Any], bool], method: str, *args: Any) -> Any:
        """Call a method, check the form of the value and return it.

        Raises:
            MasterMethodError: the value is not valid.
        """
        value = self.call(method, *args)
        if not is_valid(value):
            raise self._method_error(method, f"it replied {value!r:.60}. Is it a master?")
        return value

    def call_unchecked(self, method: str, *args: Any) -> Any:
        """Call any method with the caller id and ``args``, and return the entire ``[code, message, value]`` reply."""
        return self._request(method, self.caller_id, *args)

    def multicall(self, calls: Sequence[tuple[str, Sequence[Any]]], *, timeout: float | None = None) -> list[Any]:
        """Make many calls, in one round trip if the master supports that. The caller id is added to each call as the
        first argument.

        Args:
            calls: the method and arguments of each call.
            timeout: maximum number of seconds for a round trip; None for the client's timeout.

        Returns:
            The value of each call, or its MasterError or ProtocolError, which is returned instead of raised.
        """
        replies = None
        if not self._lacks_multicall and len(calls) > 1:
            request = [{"methodName": method, "params": [self.caller_id, *args]} for method, args in calls]
            try:
                replies = self._request("system.multicall", request, timeout=timeout)
            except MasterMethodError:
                self._lacks_multicall = True
        if not isinstance(replies, list) or len(replies) != len(calls) or isinstance(replies[0], int):
            return [self._attempt(method, args, timeout) for method, args in calls]
        results: list[Any] = []
        for (method, _), reply in zip(calls, replies, strict=True):
            try:
                if isinstance(reply, dict):
                    raise self._method_error(method, str(reply.get("faultString", "")))
                if not isinstance(reply, list) or len(reply) != 1:
                    raise ProtocolError(
                        f"{self._describe_master(method)}, inside a multicall, with something other than one value"
                    )
                results.append(unpack_reply(reply[0], self._describe_master(method)))
            except Error as error:
                results.append(error)
        return results

    def _attempt(self, method: str, args: Sequence[Any], timeout: float | None) -> Any:
        """Make one of many calls; return its value, or its error unless the master does not respond."""
        try:
            return self.call(method, *args, timeout=timeout)
        except MasterUnreachableError:
            raise
        except Error as error:
            return error

    def _method_error(self, method: str, reason: object) -> MasterMethodError:
        return MasterMethodError(f"the master at {self.uri} cannot execute {method}: {reason}")

    def _describe_master(self, method: str) -> str:
        return f"the master at {self.uri}, called with {method},"

    def _request(self, method: str, *params: Any, timeout: float | None = None) -> Any:
        try:
            return self._client.call(method, *params, timeout=timeout)
        except (UnreachableError, DeadlineError) as error:
            hint = "Is it running? Start one with: pyros1 core. Is it elsewhere? Set ROS_MASTER_URI."
            if isinstance(error, UnknownHostError):
                hint = (
                    "Is the name correct? Then use the master's IP address in ROS_MASTER_URI, "
                    f"or add a line 'ADDRESS {error.host}' to /etc/hosts."
                )
            if isinstance(error.__cause__, ConnectionResetError):
                hint = "Does its option --allow (PYROS1_ALLOW) include this machine?"
            if isinstance(error, DeadlineError):
                hint = "Is it stopped (then: kill -CONT PID), or does the network lose packets?"
            if self._closed:
                hint = "The call was not made: the calling node has shut down."
            raise MasterUnreachableError(f"no answer from the master at {self.uri} ({error}).\n{hint}", 0) from error
        except (XmlRpcFault, ProtocolError) as error:
            raise self._method_error(method, error) from error

    # ---- master

    def ping(self, timeout: float | None = None) -> None:
        """Check that the master responds, even if only with an error: some masters have no getPid.

        Args:
            timeout: maximum number of seconds to wait; None for the client's timeout.

        Raises:
            MasterUnreachableError: the master does not respond.
        """
        try:
            self.call("getPid", timeout=timeout)
        except MasterUnreachableError:
            raise
        except (MasterError, ProtocolError):
            pass

    def get_pid(self) -> int:
        """Return the master's process id."""
        return int(self._call_checked(_is_integer, "getPid"))

    def get_uri(self) -> str:
        """Return the URI that the master reports for itself."""
        return cast(str, self._call_checked(_is_string, "getUri"))

    def shutdown(self, reason: str = "") -> None:
        """Shut down the master."""
        self.call("shutdown", reason)

    def register_publisher(self, topic: str, topic_type: str, api_uri: str) -> list[str]:
        """Register a publisher; return the API URIs of the topic's subscribers."""
        return cast("list[str]", self._call_checked(_is_string_list, "registerPublisher", topic, topic_type, api_uri))

    def unregister_publisher(self, topic: str, api_uri: str) -> int:
        """Unregister a publisher; return 1, or 0 if it was not registered with that API URI."""
        return int(self._call_checked(_is_integer, "unregisterPublisher", topic, api_uri))

    def register_subscriber(self, topic: str, topic_type: str, api_uri: str) -> list[str]:
        """Register a subscriber, where type ``*`` means any; return the API URIs of the topic's publishers."""
        return cast("list[str]", self._call_checked(_is_string_list, "registerSubscriber", topic, topic_type, api_uri))

    def unregister_subscriber(self, topic: str, api_uri: str) -> int:
        """Unregister a subscriber; return 1, or 0 if it was not registered with that API URI."""
        return int(self._call_checked(_is_integer, "unregisterSubscriber", topic, api_uri))

    def register_service(self, service: str, service_uri: str, api_uri: str) -> None:
        """Register the provider of a service, replacing any previous one."""
        self.call("registerService", service, service_uri, api_uri)

    def unregister_service(self, service: str, service_uri: str) -> int:
        """Unregister the provider of a service; return 1, or 0 if it was not registered."""
        return int(self._call_checked(_is_integer, "unregisterService", service, service_uri))

    def lookup_service(self, service: str) -> str:
        """Return the ``rosrpc://`` URI of a service's provider."""
        return cast(str, self._call_checked(_is_string, "lookupService", service))

    def lookup_node(self, name: str) -> str:
        """Return the API URI of a node."""
        return cast(str, self._call_checked(_is_string, "lookupNode", name))

    def get_published_topics(self, subgraph: str = "") -> list[list[str]]:
        """Return ``[[topic, type], ...]`` for the topics that have a publisher.

        Args:
            subgraph: the namespace whose topics to return; empty for all namespaces.
        """
        try:
            return cast("list[list[str]]", self._call_checked(_is_pair_list, "getPublishedTopics", subgraph))
        except MasterMethodError:
            types = dict(cast("list[tuple[str, str]]", self._call_checked(_is_pair_list, "getTopicTypes")))
            prefix = subgraph.rstrip("/") + "/"
            return [[name, types.get(name, "*")] for name, _ in self.get_system_state()[0] if name.startswith(prefix)]

    def get_topic_types(self) -> list[list[str]]:
        """Return ``[[topic, type], ...]`` for all topics whose type the master has ever known."""
        try:
            return cast("list[list[str]]", self._call_checked(_is_pair_list, "getTopicTypes"))
        except MasterMethodError:
            return self.get_published_topics()

    def get_system_state(self) -> SystemState:
        """Return ``[publishers, subscribers, services]``, each of the form ``[[name, [node, ...]], ...]``."""
        return cast(SystemState, self._call_checked(is_system_state, "getSystemState"))

    # ---- parameters

    def get_param(self, key: str) -> Any:
        """Return a parameter's value, or a dict of all parameters in a namespace.

        Raises:
            ParameterNotSetError: the parameter is not set.
        """
        try:
            return self.call("getParam", key)
        except MasterUnreachableError:
            raise
        except MasterError as error:
            if _says_not_set(error):
                raise ParameterNotSetError(str(error)) from error
            return self._get_tree(key, error)

    def _get_tree(self, key: str, error: MasterError) -> Any:
        """Return a dict of the parameters below a key, from a master that cannot return it in one call.

        Args:
            key: the namespace.
            error: the master's response to ``getParam``.

        Raises:
            ParameterNotSetError: neither the key nor anything below it is set.
            MasterError: ``error``, if the key is itself a parameter, so that the master must have refused for another
                reason.
        """
        if isinstance(error, MasterMethodError):
            raise error
        names = self.get_param_names()
        if key in names:
            raise error
        prefix = key.rstrip("/") + "/"
        names_below = [name for name in names if name.startswith(prefix)]
        if not names_below:
            raise ParameterNotSetError(f"Parameter [{key}] is not set") from error
        tree: dict[str, Any] = {}
        for name, value in zip(
            names_below, self.multicall([("getParam", (name,)) for name in names_below]), strict=True
        ):
            if isinstance(value, Error):
                continue  # deleted meanwhile
            branch = tree
            *namespaces, leaf = name[len(prefix) :].split("/")
            for namespace in namespaces:
                child = branch.setdefault(namespace, {})
                branch = child if isinstance(child, dict) else {}
            branch[leaf] = value
        return tree

    def set_param(self, key: str, value: Any) -> None:
        """Set a parameter; a dict replaces the whole tree below the key."""
        self.call("setParam", key, value)

    def has_param(self, key: str) -> bool:
        """Return whether a parameter or namespace with that name exists."""
        try:
            return bool(self.call("hasParam", key))
        except MasterMethodError:
            try:
                self.get_param(key)
            except ParameterNotSetError:
                return False
            return True

    def delete_param(self, key: str) -> None:
        """Delete a parameter, or all parameters in a namespace.

        Raises:
            ParameterNotSetError: the parameter is not set.
        """
        try:
            self.call("deleteParam", key)
        except MasterUnreachableError:
            raise
        except MasterError as error:
            if _says_not_set(error):
                raise ParameterNotSetError(str(error)) from error
            raise

    def search_param(self, key: str) -> str | None:
        """Search for a parameter from the caller's namespace upwards; return its full name, or None if not found."""
        try:
            full_name = self.call("searchParam", key)
        except MasterUnreachableError:
            raise
        except MasterError as error:
            if error.code == -1 and str(error).startswith("Cannot find"):
                return None
            if (error.code == -1 or key.startswith("~")) and not isinstance(error, MasterMethodError):
                raise
            full_name = None
        if isinstance(full_name, str) and full_name.endswith(key):
            return full_name
        # The master cannot search, or replied with something other than a name.
        if key.startswith("/"):
            return key if self.has_param(key) else None
        first_part = key.partition("/")[0]
        namespace = self.caller_id
        while not self.has_param(f"{namespace}/{first_part}"):
            if not namespace:
                return None
            namespace = namespace.rpartition("/")[0]
        return f"{namespace}/{key}"

    def get_param_names(self) -> list[str]:
        """Return the full names of all parameters."""
        try:
            return cast("list[str]", self._call_checked(_is_string_list, "getParamNames"))
        except MasterMethodError:
            return list(_parameter_names("", self.call("getParam", "/")))

    def subscribe_param(self, api_uri: str, key: str) -> Any:
        """Ask the master to send ``paramUpdate`` calls to ``api_uri``; return the current value, or ``{}`` if it is not
        set.
        """
        return self.call("subscribeParam", api_uri, key)

    def unsubscribe_param(self, api_uri: str, key: str) -> int:
        """Ask the master to stop the ``paramUpdate`` calls; return 1, or 0 if there was no such subscription."""
        return int(self._call_checked(_is_integer, "unsubscribeParam", api_uri, key))
