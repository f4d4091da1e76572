# Python imports this when a program starts whose PYTHONPATH has this folder, as pyros1 run, launch and setup make it.
# It must work, and do no harm, in any Python: also in one without pyros1, and in Python 2.
import os
import sys

_here = os.path.dirname(os.path.abspath(__file__))


def _others():
    """Run the sitecustomize that this one hides."""
    sys.path[:] = [each for each in sys.path if os.path.abspath(each or ".") != _here]
    this = sys.modules.pop("sitecustomize", None)
    try:
        import sitecustomize  # noqa: F401
    except ImportError:
        pass
    if this is not None:
        sys.modules.setdefault("sitecustomize", this)  # Python wants to see it there


def _install():
    try:
        from pyros1.drop_in.finder import install
    except (ImportError, SyntaxError):
        return  # this Python has no pyros1, or cannot read it
    install()


_others()
_install()
