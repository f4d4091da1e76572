"""The methods of the Master and Parameter Server APIs
(https://wiki.ros.org/ROS/Master_API, https://wiki.ros.org/ROS/Parameter%20Server%20API).

Every call returns ``[code, message, value]`` (M03). The code is 1 for success, 0 for a failure, and -1 for an error by
the caller.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, Final, NamedTuple

from pyros1.ground.names import SEP
from pyros1.master import arguments
from pyros1.master.arguments import Refused, Validator
from pyros1.master.parameters import Parameters, param_updates
from pyros1.master.registry import Notice, Registry
from pyros1.net.xmlrpc_server import make_unknown_method_fault
from pyros1.wire.xmlrpc import PreparedList

LogFunction = Callable[[str, str], object]
"""``log(level, text)`` with level ``debug``, ``info``, ``warn`` or ``error``."""

Response = tuple[str, Any]
_TOPIC_TYPES_RECORD: Final = "topicTypes"
"""The method name in the journal's records that hold the types of topics. The API has no such method."""


class MasterApi:
    """The API of a master, which executes each call on the registry or the parameters.

    Args:
        notify: called with the notices that result from a call.
        log: called for each change (M57).
        on_shutdown: called with the reason when a client asks the master to shut down.
        pid: the process id that ``getPid`` returns.
        log_calls: whether to log each call as well, with level ``debug``.
        record: called with the method and the resolved arguments of each call that has changed the state, so that
            `restore` can repeat the call.

    Attributes:
        uri: the URI that ``getUri`` returns.
    """

    def __init__(
        self,
        *,
        notify: Callable[[Sequence[Notice]], object],
        log: LogFunction,
        on_shutdown: Callable[[str], object],
        pid: int,
        log_calls: bool = False,
        record: Callable[[str, Sequence[Any]], object] | None = None,
    ) -> None:
        self.registry = Registry()
        self.parameters = Parameters()
        self.uri = ""
        self._notify = notify
        self._log = log
        self._on_shutdown = on_shutdown
        self._pid = pid
        self._log_calls = log_calls
        self._record = record
        # The registry's version and system state, cached since tools often request it.
        self._cached_state: tuple[int, PreparedList] = (-1, PreparedList())

    def dispatch(self, method: str, params: Sequence[Any]) -> list[Any]:
        """Execute a call and return its response.

        Raises:
            XmlRpcFault: there is no such method (M05).
        """
        entry = METHODS.get(method)
        if entry is None:
            raise make_unknown_method_fault(method)
        if self._log_calls:
            self._log("debug", f"{method}({', '.join(map(repr, params))})")
        try:
            # The order of these checks affects the responses (M06).
            if not params:
                raise Refused("missing required caller_id parameter")
            if len(params) != len(entry.arguments) + 1:
                raise Refused("Error: bad call arity")
            caller = params[0]
            if not isinstance(caller, str):
                raise Refused("caller_id must be a string")
            values = [check(value, caller) for check, value in zip(entry.arguments, params[1:], strict=True)]
            versions_before = self.registry.version, self.parameters.version
            message, value = entry.perform(self, caller, *values)
        except Refused as refused:
            if not entry.is_query:
                self._log("error", f"{method}: {refused.message}")
            return [refused.code, refused.message, entry.default if refused.value is None else refused.value]
        if self._record is not None and versions_before != (self.registry.version, self.parameters.version):
            self._record(method, (caller, *values))
        return [1, message, value]

    # ---- recovery after a restart

    def snapshot(self) -> Iterator[tuple[str, Sequence[Any]]]:
        """Yield the calls with which `restore` can reproduce the current state."""
        yield _TOPIC_TYPES_RECORD, [self.registry.topic_types()]
        yield from self.registry.calls()
        yield "setParam", (SEP, SEP, self.parameters.get(SEP))

    def restore(self, calls: Iterable[tuple[str, Sequence[Any]]]) -> None:
        """Execute recorded calls without notifying nodes and without logging. Calls that fail are skipped."""
        notify, log, record = self._notify, self._log, self._record
        self._notify, self._log, self._record = (lambda _: None), (lambda *_: None), None
        try:
            for method, params in calls:
                if method == _TOPIC_TYPES_RECORD:
                    self.registry.restore_types(_parse_types(params))
                elif method in METHODS and METHODS[method].changes_state:
                    self.dispatch(method, params)
        finally:
            self._notify, self._log, self._record = notify, log, record

    # ---- about the master

    def _get_pid(self, caller: str) -> Response:
        return "", self._pid

    def _get_uri(self, caller: str) -> Response:
        return "", self.uri

    def _shutdown(self, caller: str, reason: Any) -> Response:
        self._on_shutdown(str(reason))
        return "shutdown", 0

    # ---- topics and services

    def _register_publisher(self, caller: str, topic: str, topic_type: str, api: str) -> Response:
        notices = self.registry.register_publisher(caller, topic, topic_type, api)
        self._log("info", f"+PUB [{topic}] {caller} {api}")
        self._notify(notices)
        return f"Registered [{caller}] as publisher of [{topic}]", self.registry.subscriber_apis(topic)

    def _register_subscriber(self, caller: str, topic: str, topic_type: str, api: str) -> Response:
        notices = self.registry.register_subscriber(caller, topic, topic_type, api)
        self._log("info", f"+SUB [{topic}] {caller} {api}")
        self._notify(notices)
        return f"Subscribed to [{topic}]", self.registry.publisher_apis(topic)

    def _unregister_publisher(self, caller: str, topic: str, api: str) -> Response:
        is_known = self.registry.node_api(caller) is not None
        notices = self.registry.unregister_publisher(caller, topic, api)
        self._log("info", f"-PUB [{topic}] {caller} {api}")
        self._notify(notices or ())
        return self._unregister_response(caller, topic, is_known, notices is not None)

    def _unregister_subscriber(self, caller: str, topic: str, api: str) -> Response:
        is_known = self.registry.node_api(caller) is not None
        is_removed = self.registry.unregister_subscriber(caller, topic, api)
        self._log("info", f"-SUB [{topic}] {caller} {api}")
        return self._unregister_response(caller, topic, is_known, is_removed)

    @staticmethod
    def _unregister_response(caller: str, topic: str, is_known: bool, is_removed: bool) -> Response:
        if is_removed:
            return f"Unregistered [{caller}] as provider of [{topic}]", 1
        if is_known:
            return f"[{caller}] is not a known provider of [{topic}]", 0
        return f"[{caller}] is not a registered node", 0

    def _register_service(self, caller: str, service: str, uri: str, api: str) -> Response:
        notices = self.registry.register_service(caller, service, uri, api)
        self._log("info", f"+SERVICE [{service}] {caller} {api}")
        self._notify(notices)
        return f"Registered [{caller}] as provider of [{service}]", 1

    def _unregister_service(self, caller: str, service: str, uri: str) -> Response:
        is_known = self.registry.node_api(caller) is not None
        is_removed = self.registry.unregister_service(caller, service, uri)
        self._log("info", f"-SERVICE [{service}] {caller} {uri}")
        if is_removed:
            return f"Unregistered [{caller}] as provider of [{service}]", 1
        if not is_known:
            return f"[{caller}] is not a registered node", 0
        return f"[{uri}] is no longer the current service api handle for [{service}]", 0

    def _lookup_service(self, caller: str, service: str) -> Response:
        uri = self.registry.service_uri(service)
        if uri is None:
            raise Refused("no provider")
        return f"rosrpc URI: [{uri}]", uri

    def _lookup_node(self, caller: str, node: str) -> Response:
        api = self.registry.node_api(node)
        if api is None:
            raise Refused(f"unknown node [{node}]")
        return "node api", api

    def _get_published_topics(self, caller: str, subgraph: str) -> Response:
        return "current topics", self.registry.published_topics(subgraph)

    def _get_topic_types(self, caller: str) -> Response:
        return "current system state", self.registry.topic_types()

    def _get_system_state(self, caller: str) -> Response:
        version = self.registry.version
        if self._cached_state[0] != version:
            self._cached_state = (version, PreparedList(self.registry.system_state()))
        return "current system state", self._cached_state[1]

    # ---- parameters

    def _set_param(self, caller: str, key: str, value: Any) -> Response:
        try:
            self.parameters.set(key, value)
        except ValueError as error:
            raise Refused(f"Error: invalid arguments: {error}") from error
        self._log("info", f"+PARAM [{key}] by {caller}")
        self._notify(param_updates(self.registry.param_subscribers, key, value, caller))
        return f"parameter {key} set", 0

    def _get_param(self, caller: str, key: str) -> Response:
        try:
            return f"Parameter [{key}]", self.parameters.get(key)
        except KeyError as error:
            raise Refused(f"Parameter [{key}] is not set") from error

    def _has_param(self, caller: str, key: str) -> Response:
        return key, key in self.parameters

    def _delete_param(self, caller: str, key: str) -> Response:
        try:
            self.parameters.delete(key)
        except KeyError as error:
            raise Refused(f"parameter [{key}] is not set") from error
        self._log("info", f"-PARAM [{key}] by {caller}")
        self._notify(param_updates(self.registry.param_subscribers, key, {}, None))
        return f"parameter {key} deleted", 0

    def _search_param(self, caller: str, key: str) -> Response:
        try:
            full_key = self.parameters.search(caller, key)
        except ValueError as error:
            raise Refused(f"Internal failure: {error}", 0) from error
        if full_key is None:
            raise Refused(f"Cannot find parameter [{key}] in an upwards search", value="")
        return f"Found [{full_key}]", full_key

    def _get_param_names(self, caller: str) -> Response:
        return "Parameter names", self.parameters.names()

    def _subscribe_param(self, caller: str, api: str, key: str) -> Response:
        notices = self.registry.subscribe_param(caller, key, api)
        self._log("info", f"+CACHEDPARAM [{key}] by {caller}")
        self._notify(notices)
        try:
            value = self.parameters.get(key)
        except KeyError:
            value = {}
        return f"Subscribed to parameter [{key}]", value

    def _unsubscribe_param(self, caller: str, api: str, key: str) -> Response:
        self.registry.unsubscribe_param(caller, key, api)
        self._log("info", f"-CACHEDPARAM [{key}] by {caller}")
        return f"Unsubscribe to parameter [{key}]", 1


def _parse_types(params: Sequence[Any]) -> list[tuple[str, str]]:
    """Return the well-formed ``(topic, type)`` entries of recorded topic types."""
    rows = params[0] if params and isinstance(params[0], list) else []
    return [
        (row[0], row[1])
        for row in rows
        if isinstance(row, list) and len(row) == 2 and isinstance(row[0], str) and isinstance(row[1], str)
    ]


class Method(NamedTuple):
    """A row of the API table.

    Attributes:
        perform: the implementation; called with the API, the caller's id and the validated arguments; returns the
            message and the value.
        default: the value to return with a code other than 1.
        arguments: validators of the arguments after the caller's id.
        is_query: whether the call asks for something that may not exist, so that a refusal is not logged as an error.
        changes_state: whether the call may change the state of the master.
    """

    perform: Callable[..., Response]
    default: Any
    arguments: tuple[Validator, ...] = ()
    is_query: bool = False
    changes_state: bool = False


_TOPIC: Final = arguments.make_name_validator("topic")
_SERVICE: Final = arguments.make_name_validator("service")
_CALLER_API: Final = arguments.make_api_validator("caller_api")
_SERVICE_API: Final = arguments.make_api_validator("service_api")
_TYPE: Final = arguments.validate_topic_type
_KEY: Final = arguments.validate_key

METHODS: Final[dict[str, Method]] = {
    "getPid": Method(MasterApi._get_pid, -1),
    "getUri": Method(MasterApi._get_uri, ""),
    "shutdown": Method(MasterApi._shutdown, 0, (arguments.accept_any,)),
    "registerPublisher": Method(MasterApi._register_publisher, [], (_TOPIC, _TYPE, _CALLER_API), changes_state=True),
    "registerSubscriber": Method(MasterApi._register_subscriber, [], (_TOPIC, _TYPE, _CALLER_API), changes_state=True),
    "unregisterPublisher": Method(MasterApi._unregister_publisher, 0, (_TOPIC, _CALLER_API), changes_state=True),
    "unregisterSubscriber": Method(MasterApi._unregister_subscriber, 0, (_TOPIC, _CALLER_API), changes_state=True),
    "registerService": Method(
        MasterApi._register_service, 0, (_SERVICE, _SERVICE_API, _CALLER_API), changes_state=True
    ),
    "unregisterService": Method(MasterApi._unregister_service, 0, (_SERVICE, _SERVICE_API), changes_state=True),
    "lookupService": Method(MasterApi._lookup_service, "", (_SERVICE,), is_query=True),
    "lookupNode": Method(MasterApi._lookup_node, "", (arguments.validate_node_name,), is_query=True),
    "getPublishedTopics": Method(MasterApi._get_published_topics, 0, (arguments.validate_subgraph,)),
    "getTopicTypes": Method(MasterApi._get_topic_types, []),
    "getSystemState": Method(MasterApi._get_system_state, [[], [], []]),
    "setParam": Method(MasterApi._set_param, 0, (_KEY, arguments.validate_parameter_value), changes_state=True),
    "getParam": Method(MasterApi._get_param, 0, (_KEY,), is_query=True),
    "hasParam": Method(MasterApi._has_param, False, (_KEY,)),
    "deleteParam": Method(MasterApi._delete_param, 0, (_KEY,), is_query=True, changes_state=True),
    "searchParam": Method(MasterApi._search_param, 0, (arguments.validate_raw_key,), is_query=True),
    "getParamNames": Method(MasterApi._get_param_names, []),
    "subscribeParam": Method(MasterApi._subscribe_param, 0, (_CALLER_API, _KEY), changes_state=True),
    "unsubscribeParam": Method(MasterApi._unsubscribe_param, 0, (_CALLER_API, _KEY), changes_state=True),
}
