"""The error for invalid arguments, and a validator."""


class ParameterInvalid(Exception):
    """An argument is not valid."""


def non_empty(param_name):  # type: ignore[no-untyped-def]
    """Return a check that a value is not empty, called with (value, caller id)."""

    def check(value, caller_id):  # type: ignore[no-untyped-def]
        if not value:
            raise ParameterInvalid(f"ERROR: parameter [{param_name}] must be specified and non-empty")
        return value

    return check
