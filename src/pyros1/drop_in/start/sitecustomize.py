# Python imports this when a program starts whose PYTHONPATH contains this folder, as set by pyros1 run, launch and
# setup. It must work, and do no harm, in any Python, including one without pyros1, and Python 2.
import os
import sys

_here = os.path.dirname(os.path.abspath(__file__))


def _others():
    """Run the sitecustomize that this one hides."""
    path = list(sys.path)
    this = sys.modules.pop("sitecustomize", None)
    sys.path[:] = [each for each in path if os.path.abspath(each or ".") != _here]
    try:
        import sitecustomize  # noqa: F401
    except ImportError:
        pass
    if this is not None:
        sys.modules.setdefault("sitecustomize", this)  # Python expects it there


import pyros1_modules  # noqa: E402

try:
    _others()
finally:  # Python reports an error in theirs, and continues
    pyros1_modules.install()
