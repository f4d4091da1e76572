"""Lets other programs observe state machines, and set their initial states (https://wiki.ros.org/smach/Tutorials/Smach%20Viewer)."""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence
from typing import Any

import rospy
from smach.container import Container
from smach.user_data import UserData

from pyros1.msgs.smach_msgs.msg import SmachContainerInitialStatusCmd, SmachContainerStatus, SmachContainerStructure
from pyros1.msgs.std_msgs.msg import Header
from smach_ros.local_data import decode, encode

STATUS_TOPIC = "/smach/container_status"
INIT_TOPIC = "/smach/container_init"
STRUCTURE_TOPIC = "/smach/container_structure"
HEARTBEAT = 2.0  # seconds


class IntrospectionClient:
    """Finds introspection servers, and sets the initial states of their containers."""

    def get_servers(self) -> list[str]:
        """Return the names of the servers."""
        topics = rospy.get_published_topics()
        status_type = "smach_msgs/SmachContainerStatus"
        return [
            name[: name.rfind(STATUS_TOPIC)] for name, kind in topics if kind == status_type and STATUS_TOPIC in name
        ]

    def set_initial_state(
        self,
        server: str,
        path: str,
        initial_states: Sequence[str],
        initial_userdata: UserData | None = None,
        timeout: rospy.Duration | None = None,
    ) -> bool:
        """Set the initial states of a container.

        Args:
            server: name of the server.
            path: path of the container.
            initial_states: labels of the states.
            initial_userdata: added to the container's userdata; pyros1's servers accept plain values only.
            timeout: how long to wait for the server's confirmation; None not to wait, in which case the container may
                start before the server receives the states.

        Returns:
            Whether the server confirmed the states in time; True without a timeout.
        """
        labels = list(initial_states)
        confirmed = threading.Event()

        def on_status(status: Any) -> None:
            if status.path == path and list(status.initial_states) == labels:
                confirmed.set()

        values = {} if initial_userdata is None else {key: initial_userdata[key] for key in initial_userdata.keys()}  # noqa: SIM118
        command = SmachContainerInitialStatusCmd(path=path, initial_states=labels, local_data=encode(values))
        # Latched, since the server connects later.
        publisher = rospy.Publisher(server + INIT_TOPIC, SmachContainerInitialStatusCmd, latch=True, queue_size=1)
        publisher.publish(command)
        if timeout is None:
            return True
        subscriber = rospy.Subscriber(server + STATUS_TOPIC, SmachContainerStatus, on_status)
        end = time.monotonic() + timeout.to_sec()
        try:
            while not confirmed.wait(0.05) and not rospy.is_shutdown() and time.monotonic() < end:
                pass
            return confirmed.is_set()
        finally:
            subscriber.unregister()
            publisher.unregister()


class ContainerProxy:
    """Publishes the state of one container.

    Args:
        server_name: name of the introspection server.
        container: the container.
        path: path of the container in the whole machine.
    """

    def __init__(self, server_name: str, container: Container, path: str) -> None:
        self._container = container
        self._path = path
        self._lock = threading.Lock()
        self._stopped = False  # set by stop(); the container still calls this object afterwards
        self._structure_pub = rospy.Publisher(server_name + STRUCTURE_TOPIC, SmachContainerStructure, queue_size=100)
        self._status_pub = rospy.Publisher(server_name + STATUS_TOPIC, SmachContainerStatus, queue_size=100)
        self._init_cmd = rospy.Subscriber(
            server_name + INIT_TOPIC, SmachContainerInitialStatusCmd, self._handle_init_command
        )
        container.register_start_cb(lambda userdata, labels: self.publish_status("START"))
        container.register_transition_cb(lambda userdata, labels: self.publish_status("TRANSITION"))
        container.register_termination_cb(lambda userdata, labels, outcome: self.publish_status("TERMINATION"))

    def publish_structure(self, info_str: str = "") -> None:
        """Publish the states and edges of the container."""
        if self._stopped or self._container is None or not self._structure_pub.get_num_connections():
            return
        edges = self._container.get_internal_edges()
        self._structure_pub.publish(
            SmachContainerStructure(
                Header(stamp=rospy.Time.now()),
                self._path,
                list(self._container.get_children()),
                [outcome for outcome, _, _ in edges],
                [label for _, label, _ in edges],
                [target for _, _, target in edges],
                list(self._container.get_registered_outcomes()),
            )
        )

    def publish_status(self, info_str: str = "") -> None:
        """Publish the active states and the userdata of the container.

        Args:
            info_str: the reason: "HEARTBEAT", "START", "TRANSITION", "TERMINATION" or "INITIAL STATE".
        """
        if self._stopped or not self._status_pub.get_num_connections():
            return  # nobody receives the message, and the userdata may be large
        userdata = self._container.userdata
        values = {key: userdata[key] for key in userdata.keys()}  # noqa: SIM118
        message = SmachContainerStatus(
            Header(stamp=rospy.Time.now()),
            self._path,
            self._container.get_initial_states(),
            self._container.get_active_states(),
            encode(values),
            info_str,
        )
        with self._lock:
            self._status_pub.publish(message)

    def _handle_init_command(self, command: Any) -> None:
        if command.path != self._path:
            return
        unknown = [label for label in command.initial_states if label not in self._container.get_children()]
        if unknown or not command.initial_states:
            rospy.logerr("Cannot begin with states %s: '%s' has no such states.", command.initial_states, self._path)
            return
        userdata = UserData()
        try:
            for key, value in decode(command.local_data).items():
                userdata[key] = value
        except ValueError as error:
            rospy.logwarn("The userdata in a command for '%s' is ignored: %s", self._path, error)
        rospy.logdebug("Setting initial state in smach path '%s' to %s.", self._path, command.initial_states)
        self._container.set_initial_state(list(command.initial_states), userdata)
        self.publish_status("INITIAL STATE")

    def stop(self) -> None:
        """Unregister the publishers and the subscriber."""
        self._stopped = True
        for topic in (self._structure_pub, self._status_pub, self._init_cmd):
            topic.unregister()


class IntrospectionServer:
    """Publishes the state of a container and its nested containers, and lets other programs set their initial states.

    Publishes ``SERVER_NAME/smach/container_structure`` every two seconds, and ``.../container_status`` every two
    seconds and when a container starts, changes state or ends, or its initial state is set. Listens to
    ``.../container_init``.

    Args:
        server_name: prefix of the topics.
        state: the container, with all its states already added.
        path: path of the container, as other programs show it; a prefix of the paths of the containers in it.
    """

    def __init__(self, server_name: str, state: Any, path: str) -> None:
        self._server_name = server_name
        self._state = state
        self._path = path
        self._proxies: list[ContainerProxy] = []
        self._stopped = threading.Event()
        self._thread: threading.Thread | None = None

    def start(self) -> None:
        """Start publishing the containers' state, and listening for initial states."""
        if self._thread is not None:
            return
        self.construct(self._server_name, self._state, self._path)
        self._stopped.clear()
        self._thread = threading.Thread(
            target=self._publish_periodically, name=f"{self._server_name} introspection", daemon=True
        )
        self._thread.start()
        rospy.core.add_preshutdown_hook(lambda reason: self._stopped.set())

    def stop(self) -> None:
        """Stop publishing and listening."""
        self._stopped.set()
        thread, self._thread = self._thread, None
        if thread is not None and thread is not threading.current_thread():
            thread.join(HEARTBEAT)
        self.clear()

    def construct(self, server_name: str, state: Any, path: str) -> None:
        """Create a proxy for a container and for all containers in it."""
        if not isinstance(state, Container):
            return
        self._proxies.append(ContainerProxy(server_name, state, path))
        for label, child in state.get_children().items():
            self.construct(server_name, child, f"{path}/{label}")

    def clear(self) -> None:
        """Stop all proxies."""
        proxies, self._proxies = self._proxies, []
        for proxy in proxies:
            proxy.stop()

    def _publish_periodically(self) -> None:
        while not self._stopped.wait(HEARTBEAT) and not rospy.is_shutdown():
            for proxy in self._proxies:
                try:
                    proxy.publish_structure("HEARTBEAT")
                    proxy.publish_status("HEARTBEAT")
                except rospy.ROSException:
                    return  # the node, or this server, has ended


__all__ = ["IntrospectionClient", "IntrospectionServer"]
