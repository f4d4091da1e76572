"""Restores unittest's old names, such as ``assertEquals`` and ``assert_``, which Python 3.12 removed but tests of ROS
packages use.
"""

from __future__ import annotations

import functools
import unittest
import warnings
from collections.abc import Callable
from typing import Any

_NEW_NAMES = {
    "assert_": "assertTrue",
    "assertEquals": "assertEqual",
    "assertNotEquals": "assertNotEqual",
    "assertAlmostEquals": "assertAlmostEqual",
    "assertNotAlmostEquals": "assertNotAlmostEqual",
    "assertRegexpMatches": "assertRegex",
    "assertNotRegexpMatches": "assertNotRegex",
    "assertRaisesRegexp": "assertRaisesRegex",
    "failUnlessEqual": "assertEqual",
    "failIfEqual": "assertNotEqual",
    "failUnlessAlmostEqual": "assertAlmostEqual",
    "failIfAlmostEqual": "assertNotAlmostEqual",
    "failUnless": "assertTrue",
    "failUnlessRaises": "assertRaises",
    "failIf": "assertFalse",
}


def restore(case: type[Any] = unittest.TestCase) -> None:
    """Add the old names that a class of tests lacks; existing ones are kept."""
    for old, new in _NEW_NAMES.items():
        if not hasattr(case, old):
            setattr(case, old, _make_alias(old, new))


def _make_alias(old: str, new: str) -> Callable[..., Any]:
    @functools.wraps(getattr(unittest.TestCase, new))
    def method(self: unittest.TestCase, *args: Any, **kwargs: Any) -> Any:
        warnings.warn(f"Please use {new} instead of {old}.", DeprecationWarning, stacklevel=2)
        return getattr(self, new)(*args, **kwargs)

    return method
