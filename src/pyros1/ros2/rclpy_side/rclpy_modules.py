"""The parts of rclpy that a bridge uses, and how its versions differ."""

from __future__ import annotations

from importlib import import_module
from typing import Any


class RclpyModules:
    """rclpy's functions and classes. Creating an object imports rclpy, by name, so that type checkers do not need it.

    Raises:
        ImportError: it cannot be imported.

    Attributes:
        qos: the module ``rclpy.qos``.
        serialize: encodes a message.
        deserialize: decodes a message of a given class.
        group: lets callbacks of all subscribers and services run while others wait for responses.
        tells_info: whether subscribers can receive information about a message besides the message.
        tells_publishers: whether this may include its publisher, as since Kilted.
    """

    def __init__(self) -> None:
        self._node = import_module("rclpy.node")
        self._context = import_module("rclpy.context")
        self._executors = import_module("rclpy.executors")
        self._task = import_module("rclpy.task")
        self.qos: Any = import_module("rclpy.qos")
        serialization = import_module("rclpy.serialization")
        self.serialize: Any = serialization.serialize_message
        self.deserialize: Any = serialization.deserialize_message
        self.group: Any = import_module("rclpy.callback_groups").ReentrantCallbackGroup()
        subscription = import_module("rclpy.subscription")
        self.tells_info = hasattr(subscription.Subscription, "CallbackType")
        info = getattr(subscription, "MessageInfo", None)
        self.tells_publishers = "publisher_gid" in getattr(info, "__annotations__", {})

    def start(self, node_name: str, domain: int) -> tuple[Any, Any, Any]:
        """Return a context, a node and an executor for it.

        Sets up neither signal handlers nor ROS 2's logging, since a process has only one of each.

        Raises:
            Exception: rclpy's own, of any kind.
        """
        context = self._context.Context()
        context.init(args=[], initialize_logging=False, domain_id=domain)
        try:
            executor = self._executors.SingleThreadedExecutor(context=context)
            node = self.make_node(node_name, context, executor)
        except BaseException:
            context.try_shutdown()
            raise
        return context, node, executor

    def make_node(self, name: str, context: Any, executor: Any) -> Any:
        """Return a new node for an executor."""
        node = self._node.Node(
            name, context=context, use_global_arguments=False, enable_rosout=False, start_parameter_services=False
        )
        executor.add_node(node)
        return node

    def future(self, executor: Any) -> Any:
        """Return a future that a callback can wait for."""
        return self._task.Future(executor=executor)


def rmw_name() -> str:
    """Return the name of the middleware that rclpy uses, such as ``rmw_fastrtps_cpp``.

    Raises:
        ImportError: rclpy cannot be imported.
        Exception: rclpy's own, if there is no middleware.
    """
    return str(import_module("rclpy.utilities").get_rmw_implementation_identifier())
