# Python imports this when a program starts whose PYTHONPATH has this folder, as pyros1 run, launch and setup make it.
# It must work, and do no harm, in any Python: also in one without pyros1, and in Python 2.
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
        sys.modules.setdefault("sitecustomize", this)  # Python wants to see it there


import pyros1_modules  # noqa: E402

try:
    _others()
finally:  # Python reports an error in theirs, and goes on
    pyros1_modules.install()
