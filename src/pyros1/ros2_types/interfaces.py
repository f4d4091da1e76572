"""Composes the types that ROS 2 generates for services and actions, besides those in their definitions.

For a service, this is the event for tracing its calls. For an action, these are the services that send a goal and get
its result, and the feedback message (https://design.ros2.org/articles/actions.html). No I/O.
"""

from __future__ import annotations

from pyros1.ros2_types.model import Field, FieldType, Length, MessageType, Types
from pyros1.ros2_types.nesting import LayeredTypes, find_type

_TIME = FieldType("builtin_interfaces/msg/Time")
_UUID = FieldType("unique_identifier_msgs/msg/UUID")
_EVENT_INFO = FieldType("service_msgs/msg/ServiceEventInfo")

_STANDARD_TYPES = (
    MessageType(_TIME.base, (Field("sec", FieldType("int32")), Field("nanosec", FieldType("uint32")))),
    MessageType(_UUID.base, (Field("uuid", FieldType("uint8", Length.FIXED, 16)),)),
    MessageType(
        _EVENT_INFO.base,
        (
            Field("event_type", FieldType("uint8")),
            Field("stamp", _TIME),
            Field("client_gid", FieldType("uint8", Length.FIXED, 16)),
            Field("sequence_number", FieldType("int64")),
        ),
    ),
)

_SEND_GOAL = "_SendGoal"
_GET_RESULT = "_GetResult"


def action_types(name: str, types: Types) -> dict[str, MessageType]:
    """Return the types that are sent for an action.

    Args:
        name: full name, for example ``example_interfaces/action/Fibonacci``.
        types: contains the types of its goal, result and feedback.

    Returns:
        Full name -> type, for request and response of ``..._SendGoal`` and ``..._GetResult``, for
        ``..._FeedbackMessage``, and for the standard types that these use and `types` lacks.

    Raises:
        UnknownTypeError: goal, result or feedback is missing.
    """
    goal, result, feedback = (find_type(name + part, types).name for part in ("_Goal", "_Result", "_Feedback"))
    goal_id = Field("goal_id", _UUID)
    sent = (
        MessageType(f"{name}{_SEND_GOAL}_Request", (goal_id, Field("goal", FieldType(goal)))),
        MessageType(f"{name}{_SEND_GOAL}_Response", (Field("accepted", FieldType("bool")), Field("stamp", _TIME))),
        MessageType(f"{name}{_GET_RESULT}_Request", (goal_id,)),
        MessageType(
            f"{name}{_GET_RESULT}_Response", (Field("status", FieldType("int8")), Field("result", FieldType(result)))
        ),
        MessageType(f"{name}_FeedbackMessage", (goal_id, Field("feedback", FieldType(feedback)))),
    )
    return _by_name(*sent) | _missing_standard_types(types)


def service_types(name: str, types: Types) -> dict[str, MessageType]:
    """Return the types that describe a service as a whole.

    Args:
        name: full name, for example ``std_srvs/srv/SetBool`` or ``example_interfaces/action/Fibonacci_SendGoal``.
        types: contains its request and response, or, for an action's services, the action's goal, result and feedback.

    Returns:
        Full name -> type: the service itself, with the fields ``request_message``, ``response_message`` and
        ``event_message``; the event; and the types that these use and `types` lacks.

    Raises:
        UnknownTypeError: request, response, or a part of the action is missing.
    """
    needed = _missing_standard_types(types)
    folder = name.split("/")[1:2]
    for suffix in (_SEND_GOAL, _GET_RESULT):
        if folder == ["action"] and name.endswith(suffix):
            needed |= action_types(name[: -len(suffix)], types)
    known = LayeredTypes(needed, types)
    request, response = (find_type(name + part, known).name for part in ("_Request", "_Response"))
    event = MessageType(
        f"{name}_Event",
        (
            Field("info", _EVENT_INFO),
            Field("request", FieldType(request, Length.BOUNDED, 1)),
            Field("response", FieldType(response, Length.BOUNDED, 1)),
        ),
    )
    service = MessageType(
        name,
        (
            Field("request_message", FieldType(request)),
            Field("response_message", FieldType(response)),
            Field("event_message", FieldType(event.name)),
        ),
    )
    return needed | _by_name(service, event)


def whole_action_types(name: str, types: Types) -> dict[str, MessageType]:
    """Return the types that describe an action as a whole.

    Args:
        name: full name, for example ``example_interfaces/action/Fibonacci``.
        types: contains the types of its goal, result and feedback.

    Returns:
        Full name -> type: the action itself, its services, and the types that these use and `types` lacks.

    Raises:
        UnknownTypeError: goal, result or feedback is missing.
    """
    send_goal = service_types(name + _SEND_GOAL, types)
    get_result = service_types(name + _GET_RESULT, types)
    used = {
        "goal": f"{name}_Goal",
        "result": f"{name}_Result",
        "feedback": f"{name}_Feedback",
        "send_goal_service": f"{name}{_SEND_GOAL}",
        "get_result_service": f"{name}{_GET_RESULT}",
        "feedback_message": f"{name}_FeedbackMessage",
    }
    action = MessageType(name, tuple(Field(field, FieldType(type_name)) for field, type_name in used.items()))
    return send_goal | get_result | _by_name(action)


def _missing_standard_types(types: Types) -> dict[str, MessageType]:
    return _by_name(*(each for each in _STANDARD_TYPES if each.name not in types))


def _by_name(*message_types: MessageType) -> dict[str, MessageType]:
    return {each.name: each for each in message_types}
