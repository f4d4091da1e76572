# Python imports this module when a program starts, if PYTHONPATH contains this folder, which is set by pyros1 run,
# launch and setup. It must work with any Python, including Python 2 and one without pyros1, and do no harm.
import os
import sys

_here = os.path.dirname(os.path.abspath(__file__))


def _run_hidden_sitecustomize():
    """Run the sitecustomize that is hidden by this one."""
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
    _run_hidden_sitecustomize()
finally:  # Python reports an error in the other sitecustomize, and continues
    pyros1_modules.install()
