"""A state that calls a service (https://wiki.ros.org/smach/Tutorials/ServiceState)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import rospy

from smach_ros.call_state import CallState, UserCallback


class ServiceState(CallState):
    """A state that calls a service; outcomes "succeeded", "aborted" and "preempted".

    Args:
        service_name: name of the service.
        service_spec: class of the service.
        request: the request, if nothing else provides one; None for an empty one.
        request_cb: called with the userdata and the request, then ``request_cb_args`` and ``request_cb_kwargs``; it
            changes the request, or returns another one.
        request_key: userdata key of a whole request.
        request_slots: userdata keys that are fields of the request.
        response_cb: called with the userdata and the response, then its own arguments; it may return an outcome.
        response_key, response_slots: userdata keys in which the whole response, or fields of it, are stored.
        input_keys, output_keys, outcomes: additional ones, which the callbacks use.
    """

    def __init__(
        self,
        service_name: str,
        service_spec: Any,
        request: Any = None,
        request_cb: Callable[..., Any] | None = None,
        request_cb_args: Sequence[Any] = (),
        request_cb_kwargs: Mapping[str, Any] | None = None,
        request_key: str | None = None,
        request_slots: Iterable[str] = (),
        response_cb: Callable[..., Any] | None = None,
        response_cb_args: Sequence[Any] = (),
        response_cb_kwargs: Mapping[str, Any] | None = None,
        response_key: str | None = None,
        response_slots: Iterable[str] = (),
        input_keys: Iterable[str] = (),
        output_keys: Iterable[str] = (),
        outcomes: Iterable[str] = (),
    ) -> None:
        super().__init__(
            ("request", "response"),
            service_spec._request_class() if request is None else request,
            (request_key, request_slots, UserCallback(request_cb, request_cb_args, request_cb_kwargs)),
            (response_key, response_slots, UserCallback(response_cb, response_cb_args, response_cb_kwargs)),
            (input_keys, output_keys, outcomes),
        )
        self._service_name = service_name
        self._service_spec = service_spec

    def execute(self, ud: Any) -> Any:
        """Wait for the service, call it, and return the outcome."""
        if not self._wait_for_service():
            self.service_preempt()
            return "preempted"
        try:
            request = self._make_message(ud)
            response = rospy.ServiceProxy(self._service_name, self._service_spec)(request)
        except rospy.ServiceException as error:
            rospy.logerr("Exception when calling service '%s': %s", self._service_name, error)
            return "aborted"
        self._store(ud, response)
        return self._received_callback(ud, response) or "succeeded"

    def _wait_for_service(self) -> bool:
        """Wait until the service exists; return False if preempted, or if the node shuts down."""
        while not self.preempt_requested() and not rospy.is_shutdown():
            try:
                rospy.wait_for_service(self._service_name, 1.0)
            except rospy.ROSInterruptException:
                return False
            except rospy.ROSException:
                rospy.logwarn("Still waiting for service '%s'...", self._service_name)
            else:
                return not self.preempt_requested()
        return False


__all__ = ["ServiceState"]
