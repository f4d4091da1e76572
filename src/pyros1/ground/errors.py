"""All errors that pyros1 raises, as one hierarchy.

::

    Error
    ├── InvalidNameError (ValueError)       a graph resource name is not valid
    ├── MessageError
    │   ├── DefinitionError                 a .msg/.srv/.action text is invalid; names file and line
    │   ├── UnknownTypeError                no definition of that message or service type was found
    │   ├── SerializationError              a value does not fit its field
    │   ├── DeserializationError            received bytes cannot be decoded; names type and offset
    │   └── LengthError                     received bytes are a message, with too many or too few bytes
    ├── TransportError
    │   ├── ProtocolError                   the peer violated the protocol (header, framing, HTTP, XML)
    │   ├── ConnectionRefusedByPeerError    the peer responded with an ``error=`` header
    │   ├── UnreachableError                no connection could be made, or it was lost
    │   │   └── UnknownHostError            the peer's host name cannot be resolved
    │   └── DeadlineError (TimeoutError)    the peer did not respond in time
    ├── XmlRpcFault                         the remote side responded with an XML-RPC fault
    ├── MasterError                         the master responded with code 0 or -1
    │   ├── MasterMethodError               the master does not have the method, or the method failed
    │   └── MasterUnreachableError          the master did not respond at all
    ├── ServiceError                        a service call failed, in the client or in the handler
    │   ├── ServiceUnavailableError         the service has no provider, or its node cannot be reached
    │   └── ServiceRefusal                  raised by a handler: only the caller gets the message; nothing is logged
    ├── ParameterNotSetError (KeyError)     the parameter is not on the parameter server
    ├── WaitTimeoutError (TimeoutError)     a message, service or the master was not available in time
    ├── NodeError                           a node cannot do what was requested (closed, declared twice, ...)
    │   └── NodeShutdownError               a wait was cut short because the node is shutting down
    ├── TimeMovedBackwardsError             simulated time jumped back during a sleep
    ├── PackageNotFoundError (LookupError)  no ROS package has that name
    └── LaunchError                         a launch file or its nodes cannot be used; names file and line
"""

from __future__ import annotations

from pyros1.ground import terminal_text


class Error(Exception):
    """Base of all pyros1 errors; the message is for display, so it contains no control characters."""

    def __str__(self) -> str:
        return terminal_text.lines(super().__str__())


class InvalidNameError(Error, ValueError):
    """A graph resource name violates the naming rules (https://wiki.ros.org/Names)."""


class SettingError(Error, ValueError):
    """An environment variable, a command-line argument or a parameter has a value that cannot be used."""


class MessageError(Error):
    """A message definition, a value or received bytes cannot be used."""


class DefinitionError(MessageError):
    """The text of a definition is invalid.

    Args:
        message: what is wrong.
        where: file name or type name; None if unknown.
        line: 1-based line number; None if unknown.
    """

    def __init__(self, message: str, where: str | None = None, line: int | None = None) -> None:
        self.where = where
        self.line = line
        location = f"{where or '<definition>'}:{line}: " if line is not None else f"{where}: " if where else ""
        super().__init__(terminal_text.one_line(location + message, 10_000))  # the message quotes text from elsewhere


class UnknownTypeError(MessageError):
    """No definition of this type was found."""


class SerializationError(MessageError):
    """A field's value cannot be written as the field's type."""


class DeserializationError(MessageError):
    """Received bytes are not a message of the expected type.

    Args:
        type_name: the expected type, for example ``std_msgs/String``. If it is the only argument, it is the whole text
            of the error: programs and generated modules raise the error that way.
        offset: offset in the message body at which decoding failed, in bytes.
        reason: what is wrong at that offset.
    """

    def __init__(self, type_name: object = "", offset: int | None = None, reason: str = "") -> None:
        self.type_name = str(type_name)
        self.offset = offset
        self.reason = reason
        super().__init__(type_name if offset is None else f"cannot decode {type_name} at byte {offset}: {reason}")


class LengthError(MessageError):
    """Received bytes are a message of the expected type, but with the wrong length.

    Decoders only raise this if their argument ``exact`` is True; otherwise they ignore the difference, as in stock ROS.

    Args:
        type_name: the expected type, for example ``std_msgs/String``.
        surplus: number of bytes after the message; if negative, the number of bytes missing from its last string or
            byte array.
    """

    def __init__(self, type_name: str, surplus: int) -> None:
        self.surplus = surplus
        amount = f"{abs(surplus)} byte{'s' * (abs(surplus) != 1)}"
        difference = f"{amount.replace(' ', ' surplus ')} at its end" if surplus > 0 else f"{amount} missing at its end"
        super().__init__(f"a {type_name} with {difference}")


class TransportError(Error):
    """Communication with another process has failed."""


class ProtocolError(TransportError):
    """The peer sent something that the protocol does not allow."""


class ConnectionRefusedByPeerError(TransportError):
    """The peer refused the connection with an ``error`` header; the message contains its reason."""


class UnreachableError(TransportError):
    """No connection could be made, or it was lost before the response arrived."""


class UnknownHostError(UnreachableError):
    """A host name cannot be resolved on this machine.

    Args:
        host: the host name.
        reason: the system's error; None if the look-up returned no address.
    """

    def __init__(self, host: str, reason: OSError | None) -> None:
        self.host = host
        reason_text = getattr(reason, "strerror", None) or reason or "no address"
        super().__init__(f"the host name '{host:.100}' cannot be resolved here: {reason_text}")


class DeadlineError(TransportError, TimeoutError):
    """The peer did not respond in time."""


class XmlRpcFault(Error):
    """The remote side responded with an XML-RPC fault.

    Args:
        code: the fault code.
        message: the fault string.
    """

    def __init__(self, code: int, message: str) -> None:
        self.code = code
        self.message = message
        super().__init__(f"XML-RPC fault {code}: {terminal_text.one_line(message)}")


class MasterError(Error):
    """The master, or another node's API, responded to a call with status 0 (failed) or -1 (invalid call).

    Args:
        message: the status message.
        code: 0 or -1.
    """

    def __init__(self, message: str, code: int = -1) -> None:
        self.code = code
        super().__init__(message)


class MasterMethodError(MasterError):
    """The master responded, but does not have the method (some masters have fewer than stock), or the method failed."""


class MasterUnreachableError(MasterError):
    """The master did not respond at all."""


class ServiceError(Error):
    """A service call failed; the message says where and why.

    Args:
        message: where and why the call failed.
        answer: the provider's response as received; None if there was no response.
    """

    def __init__(self, message: str, answer: bytes | None = None) -> None:
        self.answer = answer
        super().__init__(message)


class ServiceUnavailableError(ServiceError):
    """The service has no provider, or its provider cannot be reached."""


class ServiceRefusal(ServiceError):
    """Raised by the handler of a service: the caller gets exactly this message, and nothing is logged."""


class ParameterNotSetError(Error, KeyError):
    """The parameter is not set on the parameter server."""

    def __str__(self) -> str:  # KeyError would show the repr of its argument
        return terminal_text.lines(Exception.__str__(self))


class WaitTimeoutError(Error, TimeoutError):
    """A message, a service or the master was not available in time."""


class NodeError(Error):
    """A node, publisher, subscriber or service cannot do what was requested, for example because it is closed."""


class NodeShutdownError(NodeError):
    """A wait was cut short because the node is shutting down."""


class TimeMovedBackwardsError(Error):
    """Simulated time jumped back during a sleep.

    Args:
        jump: size of the jump in seconds; it is negative.
    """

    def __init__(self, jump: float) -> None:
        self.jump = jump
        super().__init__(f"time moved backwards by {-jump} s")


class PackageNotFoundError(Error, LookupError):
    """No ROS package with that name was found."""


class LaunchError(Error):
    """A launch file, or something that it requests, cannot be used.

    Args:
        message: the problem, and what to do about it.
        where: file name; None if unknown.
        line: 1-based line number; None if unknown.
    """

    def __init__(self, message: str, where: str | None = None, line: int | None = None) -> None:
        self.where = where
        self.line = line
        location = f"{where}:{line}: " if where and line else f"{where}: " if where else ""
        super().__init__(location + message)
