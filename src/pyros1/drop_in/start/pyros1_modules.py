# Makes pyros1's modules available to a program under the names of stock ROS 1. This costs nothing until the program
# imports one of them.
#
# `pyros1 run`, `launch`, `test` and `setup` put this folder on PYTHONPATH, where sitecustomize.py imports this module.
# `pyros1 rospy enable` writes a .pth file that imports it, too. This module must work with any Python, including
# Python 2 and one without pyros1, and do no harm.
import gc
import os
import sys

try:
    import _imp
    from _thread import get_ident
    from importlib.machinery import PathFinder
except ImportError:  # Python 2
    PathFinder = None

HERE = os.path.dirname(os.path.abspath(__file__))
MODULES = os.path.join(os.path.dirname(HERE), "modules")
STARTUP_MODULES = ("sitecustomize", "usercustomize")  # Python looks for them each time it starts


class PlaceholderFinder(object):
    """Stands in for the real finder at the end of sys.meta_path until no other finder finds an imported module."""

    importing_thread = None  # id of the thread that is importing the real finder

    def find_spec(self, name, path=None, target=None):
        if path is not None or name in getattr(sys, "stdlib_module_names", ()) or name.startswith("pyros1"):
            return None
        if name in STARTUP_MODULES:
            return None
        # Python holds the import lock now. Other threads that import the modules needed here may be waiting for it.
        try:
            _imp.release_lock()
        except RuntimeError:  # called by a program, not by the import system
            finder = self.replace()
        else:
            try:
                finder = self.replace()
            finally:
                _imp.acquire_lock()
        if finder is not None:
            return finder.find_spec(name, path, target)
        hint_at_missing(name)
        return None

    def find_module(self, name, path=None):  # called by Python 2
        if path is None:
            hint_at_missing(name)

    def replace(self):
        """Replace this finder with the real one, and return the real one; None if this Python has no pyros1."""
        if self.importing_thread == get_ident():
            return None  # called by the import below, which tries to import a module that does not exist
        self.importing_thread = get_ident()
        was_gc_enabled = gc.isenabled()
        gc.disable()  # as in pyros1.ground.loading: garbage collection slows down imports
        try:
            from pyros1.drop_in.finder import install
        except (ImportError, SyntaxError):  # this Python has no pyros1, or is too old for it
            return None
        finally:
            self.importing_thread = None
            if was_gc_enabled:
                gc.enable()
        finder = install()  # before this one is removed: other threads may be going through the list
        try:
            sys.meta_path.remove(self)
        except ValueError:  # another thread has removed it
            pass
        return finder


class FolderFilter(object):
    """Precedes Python's own finder, which treats any folder as a package if there is no other package with its name.

    A workspace's source folder contains folders like std_msgs, which would hide the messages without this filter. If
    stock's genpy is installed, but not its rospy, the basic modules must be pyros1's as well.
    """

    def find_spec(self, name, path=None, target=None):
        if path is not None and name.rpartition(".")[2] not in ("msg", "srv"):
            return None
        spec = PathFinder.find_spec(name, path, target)
        if spec is None:
            return None
        must_replace = name in ("genpy", "genmsg", "roslib", "rosgraph") and not is_module(
            PathFinder.find_spec("rospy")
        )
        if not must_replace and is_module(spec):
            return spec
        our_finders = [finder for finder in sys.meta_path if type(finder).__name__ in ("PlaceholderFinder", "Finder")]
        return our_finders[-1].find_spec(name, path, target) or spec if our_finders else spec


def is_module(spec):
    """Return whether a spec is for a module, not just for a folder."""
    return spec is not None and spec.has_location


def hint_at_missing(name):
    """Print a hint if a program imports one of pyros1's modules with a Python that has no pyros1."""
    if name in ("rospy", "roslib") and os.path.isdir(os.path.join(MODULES, name)):
        pyros1_python = os.environ.get("PYROS1_PYTHON", "")
        python = "Python 2" if sys.version_info[0] == 2 else sys.executable
        text = "pyros1: this program runs with %s, which has neither ROS nor pyros1, and imports %s.\n" % (python, name)
        if pyros1_python:
            text += (
                "    Activate pyros1's environment first (source %s), or write #!%s as the program's first line.\n"
                % (
                    os.path.join(os.path.dirname(pyros1_python), "activate"),
                    pyros1_python,
                )
            )
        else:
            text += "    Run it with the Python of pyros1's environment, or install pyros1 for this Python.\n"
        sys.stderr.write(text)


PYTHON2_MODULES = (
    "Queue",
    "ConfigParser",
    "StringIO",
    "cStringIO",
    "cPickle",
    "urllib2",
    "urlparse",
    "httplib",
    "thread",
)
PYTHON2_MODULES += ("Tkinter", "tkMessageBox", "commands", "exceptions", "SocketServer", "xmlrpclib", "__builtin__")
PYTHON2_NAMES = ("xrange", "unicode", "raw_input", "basestring", "long", "reduce", "unichr", "file", "cmp", "execfile")
PYTHON2_METHODS = ("has_key", "iteritems", "itervalues", "iterkeys")
PYTHON2_SYNTAX = (
    "Missing parentheses in call to",
    "multiple exception types must be parenthesized",
    "inconsistent use of tabs",
)
PYTHON2_SYNTAX += ("invalid decimal literal", "leading zeros in decimal")


def is_python2(error):
    """Return whether an error is typical of programs written for Python 2."""
    text = str(error)
    if isinstance(error, SyntaxError):
        return text.startswith(PYTHON2_SYNTAX)
    if isinstance(error, ImportError):
        return getattr(error, "name", None) in PYTHON2_MODULES
    if isinstance(error, NameError):
        return any(("name '%s' is not defined" % name) in text for name in PYTHON2_NAMES)
    if isinstance(error, AttributeError):
        return text.startswith("'dict'") and any(("'%s'" % name) in text for name in PYTHON2_METHODS)
    return False


COLLECTIONS_ABC_NAMES = (
    "Mapping",
    "MutableMapping",
    "Sequence",
    "MutableSequence",
    "Set",
    "Iterable",
    "Iterator",
    "Callable",
)
COLLECTIONS_ABC_NAMES += ("Hashable", "Sized", "Container")
REMOVED_FEATURES = (
    ("load() missing 1 required positional argument: 'Loader'", "PyYAML 6 needs a loader: write yaml.safe_load(...)"),
    ("module 'time' has no attribute 'clock'", "Python 3.8 has removed time.clock: write time.perf_counter"),
    (
        "module 'inspect' has no attribute 'getargspec'",
        "Python 3.11 has removed inspect.getargspec: write inspect.getfullargspec",
    ),
    ("No module named 'imp'", "Python 3.12 has removed imp: use importlib"),
    ("No module named 'distutils'", "Python 3.12 has removed distutils: pip install setuptools provides it"),
)
REMOVED_FEATURES += tuple(
    (part % name, "write collections.abc.%s: Python 3.10 has removed the old name" % name)
    for name in COLLECTIONS_ABC_NAMES
    for part in ("'collections' has no attribute '%s'", "import name '%s' from 'collections'")
)


def replacement_for(error):
    """Return what replaces a feature of older versions of Python or a library; None if no hint applies."""
    if not isinstance(error, (AttributeError, ImportError, TypeError)):
        return None
    text = str(error)
    return next((advice for part, advice in REMOVED_FEATURES if part in text), None)


PYTHON2_HINT = (
    "pyros1: this looks like a program for Python 2, which is unsupported since 2020. Convert it to Python 3: "
    "pip install fissix && fissix -w FILE does most of the conversion."
)


def hint_for(error):
    """Return a hint about an error that is typical of old programs; an empty string if there is none."""
    if is_python2(error):
        return PYTHON2_HINT
    advice = replacement_for(error)
    return (
        "pyros1: this program was written for an older version of Python or of a library. %s." % advice
        if advice
        else ""
    )


def take_over(name):
    """Import the actual module instead of the one with the same name in this folder.

    The folder contains modules with the names that programs import first. Python only finds them if another
    sitecustomize precedes pyros1's on PYTHONPATH, so that `install` has not been called yet.
    """
    sys.path[:] = [entry for entry in sys.path if os.path.abspath(entry or ".") != HERE]
    install()
    sys.modules.pop(name, None)
    __import__(name)


def install():
    """Make the modules available in this process, unless the environment selects stock's."""
    preference = os.environ.get("PYROS1_ROSPY", "")
    if preference == "stock" or any(
        type(finder).__name__ in ("PlaceholderFinder", "Finder") for finder in sys.meta_path
    ):
        return
    if preference not in ("", "pyros1"):
        sys.stderr.write("pyros1: PYROS1_ROSPY is '%s', not 'pyros1' or 'stock': it is ignored\n" % preference)
    if PathFinder in sys.meta_path:
        sys.meta_path.insert(sys.meta_path.index(PathFinder), FolderFilter())
    if preference == "pyros1":
        try:
            from pyros1.drop_in.finder import install

            install()
        except (ImportError, SyntaxError):
            sys.meta_path.append(PlaceholderFinder())
    else:
        sys.meta_path.append(PlaceholderFinder())
    if sys.version_info[0] == 2:
        return
    previous_hook = sys.excepthook

    def excepthook(error_type, error, traceback):
        previous_hook(error_type, error, traceback)
        hint = hint_for(error)
        if hint:
            sys.stderr.write(hint + "\n")

    sys.excepthook = excepthook
