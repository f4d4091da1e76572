# Python imports this module when a program starts, if PYTHONPATH contains this folder, which pyros1 run, launch and
# setup add to it. This module must work with any Python, including Python 2 and one without pyros1, and do no harm.
import os
import sys

_here = os.path.dirname(os.path.abspath(__file__))


def _run_hidden_sitecustomize():
    """Run the sitecustomize module that this module hides, if there is one."""
    path = list(sys.path)
    this_module = sys.modules.pop("sitecustomize", None)
    sys.path[:] = [entry for entry in path if os.path.abspath(entry or ".") != _here]
    try:
        import sitecustomize  # noqa: F401
    except ImportError:
        pass
    if this_module is not None:
        sys.modules.setdefault("sitecustomize", this_module)  # Python expects it there


import pyros1_modules  # noqa: E402

try:
    _run_hidden_sitecustomize()
finally:  # if the other sitecustomize fails, Python reports the error and continues
    pyros1_modules.install()
