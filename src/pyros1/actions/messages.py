"""The message classes of an action, and its subscriptions."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, NamedTuple

from pyros1.actions.errors import ActionError
from pyros1.msgs import load_message

if TYPE_CHECKING:
    from pyros1.node import Node
    from pyros1.node.subscribing.subscriber import Subscriber


class ActionTypes(NamedTuple):
    """The classes of the messages on an action's topics, and of the users' messages within them."""

    action_goal: Any
    action_result: Any
    action_feedback: Any
    goal: Any
    result: Any
    feedback: Any

    @classmethod
    def of(cls, given: Any) -> ActionTypes:
        """Return the classes that belong to an action.

        Args:
            given: class of the action, such as FibonacciAction, or its type's name, "actionlib_tutorials/Fibonacci",
                with or without "Action" at its end.

        Raises:
            ActionError: that is not an action.
            UnknownTypeError: there is no such type.
        """
        if isinstance(given, str):
            given = load_message(given if given.endswith("Action") else f"{given}Action")
        try:
            parts = given()
            inner = (parts.action_goal, parts.action_result, parts.action_feedback)
            outer = (parts.action_goal.goal, parts.action_result.result, parts.action_feedback.feedback)
        except (AttributeError, TypeError):
            raise ActionError(
                f"{given!r:.80} is not an action: give its class, as FibonacciAction, or its name"
            ) from None
        return cls(*map(type, inner + outer))


def subscribe_now(
    node: Node, topic: str, kind: Any, callback: Callable[[Any], None], queue_size: int
) -> Subscriber[Any]:
    """Subscribe for an action: even in a node that spins, callbacks run at once, since the program may wait in one."""
    return node._topics.subscribe(node.resolve(topic), kind, callback, queue_size, direct=True)


def links_of_node(links: Iterable[Any], name: str, name_of: Callable[[Any], str | None]) -> frozenset[object]:
    """Return a node's links, as other nodes may just listen. All links, if none is the node's: a relay is in between.

    Args:
        links: of a publisher or subscriber.
        name: the node's full name.
        name_of: returns the name of the node at the other end of a link.
    """
    found = list(links)
    return frozenset([link for link in found if name_of(link) == name] or found)
