"""Finds the message classes of an action, and subscribes to its topics."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, NamedTuple

from pyros1.actions.errors import ActionError
from pyros1.msgs import load_message

if TYPE_CHECKING:
    from pyros1.node import Node
    from pyros1.node.subscribing.subscriber import Subscriber


class ActionTypes(NamedTuple):
    """The classes of the messages on an action's topics, and of the goal, result and feedback inside them."""

    action_goal: Any
    action_result: Any
    action_feedback: Any
    goal: Any
    result: Any
    feedback: Any

    @classmethod
    def of(cls, action: Any) -> ActionTypes:
        """Return the classes that belong to an action.

        Args:
            action: the action's class, such as FibonacciAction, or the name of its type, such as
                "actionlib_tutorials/Fibonacci", with or without "Action" at its end.

        Raises:
            ActionError: ``action`` is not an action.
            UnknownTypeError: there is no such type.
        """
        if isinstance(action, str):
            action = load_message(action if action.endswith("Action") else f"{action}Action")
        try:
            fields = action()
            topic_messages = (fields.action_goal, fields.action_result, fields.action_feedback)
            contents = (fields.action_goal.goal, fields.action_result.result, fields.action_feedback.feedback)
        except (AttributeError, TypeError):
            raise ActionError(
                f"{action!r:.80} is not an action: pass its class, such as FibonacciAction, or its name"
            ) from None
        return cls(*map(type, topic_messages + contents))


def subscribe_direct(
    node: Node, topic: str, message_type: Any, callback: Callable[[Any], None], queue_size: int
) -> Subscriber[Any]:
    """Subscribe with a callback that runs immediately, even in a node that spins: the program may be waiting in a
    callback.
    """
    return node._topics.subscribe(node.resolve(topic), message_type, callback, queue_size, direct=True)


def links_of_node(links: Iterable[Any], name: str, name_of: Callable[[Any], str | None]) -> frozenset[object]:
    """Return the links to one node, since other nodes may only be listening. If no link leads to that node, as with
    a relay, return all links.

    Args:
        links: the links of a publisher or subscriber.
        name: the node's full name.
        name_of: returns the name of the node at the other end of a link.
    """
    all_links = list(links)
    return frozenset([link for link in all_links if name_of(link) == name] or all_links)
