"""Arguments and results of tf.transformations as JSON, with their types. Used by both interpreters."""

import numpy as np


def described(value):
    """Return what a value is: {type: parts}, with shape and dtype for an array; a number of numpy's as Python's."""
    if isinstance(value, np.ndarray):
        return {"array": value.tolist(), "shape": list(value.shape), "dtype": value.dtype.name}
    if isinstance(value, (list, tuple)):
        return {type(value).__name__: [described(part) for part in value]}
    return value.item() if isinstance(value, np.generic) else value


def made(value):
    """Return what `described` describes; lists and numbers may stand for themselves."""
    if isinstance(value, dict):
        if "array" in value:
            return np.array(value["array"], value["dtype"])
        ((kind, parts),) = value.items()
        return {"list": list, "tuple": tuple}[kind](made(part) for part in parts)
    return value
