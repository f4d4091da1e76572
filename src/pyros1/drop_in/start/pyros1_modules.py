# Offers pyros1's modules under the names of stock ROS 1 to a program, at no cost until it imports one.
#
# `pyros1 run`, `launch`, `test` and `setup` put this folder on PYTHONPATH, where sitecustomize.py imports this module;
# `pyros1 rospy enable` writes a .pth file that does. It must work, and do no harm, in any Python, including one without
# pyros1, and Python 2.
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


class Waiting(object):
    """Stays at the end of sys.meta_path until a module is imported that no other finder finds."""

    busy = None  # the thread that imports the real finder

    def find_spec(self, name, path=None, target=None):
        if path is not None or name in getattr(sys, "stdlib_module_names", ()) or name.startswith("pyros1"):
            return None
        # Python holds the import lock now. Other threads may be waiting for it while they import the same modules as
        # we do.
        try:
            _imp.release_lock()
        except RuntimeError:  # called by a program, not by the import system
            real = self.real()
        else:
            try:
                real = self.real()
            finally:
                _imp.acquire_lock()
        if real is not None:
            return real.find_spec(name, path, target)
        hint_at_missing(name)
        return None

    def find_module(self, name, path=None):  # Python 2 calls this one
        if path is None:
            hint_at_missing(name)

    def real(self):
        """Replace this finder by the real one; return None if this Python has no pyros1."""
        if self.busy == get_ident():
            return None  # the import below needs a module that does not exist
        self.busy = get_ident()
        collects = gc.isenabled()
        gc.disable()  # like pyros1.ground.loading
        try:
            from pyros1.drop_in.finder import install
        except (ImportError, SyntaxError):  # it has no pyros1, or is too old for it
            return None
        finally:
            self.busy = None
            if collects:
                gc.enable()
        if self in sys.meta_path:
            sys.meta_path.remove(self)
        return install()


class Folders(object):
    """Precedes Python's own finder, which takes any folder for a package if no other package has its name.

    The source folder of a workspace contains folders like std_msgs, whose messages would then not be found. The basic
    modules must be ours as well if a real genpy is installed, but no rospy.
    """

    def find_spec(self, name, path=None, target=None):
        if path is not None and name.rpartition(".")[2] not in ("msg", "srv"):
            return None
        spec = PathFinder.find_spec(name, path, target)
        if spec is None:
            return None
        lowest = name in ("genpy", "genmsg", "roslib", "rosgraph") and not is_module(PathFinder.find_spec("rospy"))
        if not lowest and is_module(spec):
            return spec
        ours = [each for each in sys.meta_path if type(each).__name__ in ("Waiting", "Finder")]
        return ours[-1].find_spec(name, path, target) or spec if ours else spec


def is_module(spec):
    """Return whether what Python has found is more than a folder."""
    return spec is not None and spec.has_location


def hint_at_missing(name):
    """Print what to do if a program imports one of the modules on a Python that has no pyros1."""
    if name in ("rospy", "roslib") and os.path.isdir(os.path.join(MODULES, name)):
        ours = os.environ.get("PYROS1_PYTHON", "")
        what = "Python 2" if sys.version_info[0] == 2 else sys.executable
        text = "pyros1: this program runs on %s, which has neither ROS nor pyros1, and imports %s.\n" % (what, name)
        if ours:
            text += (
                "    Activate pyros1's environment first (source %s), or write #!%s as the program's first line.\n"
                % (
                    os.path.join(os.path.dirname(ours), "activate"),
                    ours,
                )
            )
        else:
            text += "    Start it with the Python of pyros1's environment, or install pyros1 for this Python.\n"
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


ABC = ("Mapping", "MutableMapping", "Sequence", "MutableSequence", "Set", "Iterable", "Iterator", "Callable")
ABC += ("Hashable", "Sized", "Container")
OLDER = (
    ("load() missing 1 required positional argument: 'Loader'", "PyYAML 6 needs a loader: write yaml.safe_load(...)"),
    ("module 'time' has no attribute 'clock'", "Python 3.8 has removed time.clock: write time.perf_counter"),
    ("module 'inspect' has no attribute 'getargspec'", "Python 3.11 has removed it: write inspect.getfullargspec"),
    ("No module named 'imp'", "Python 3.12 has removed imp: importlib does its work"),
    ("No module named 'distutils'", "Python 3.12 has removed distutils: pip install setuptools brings it back"),
)
OLDER += tuple(
    (part % name, "it is collections.abc.%s now" % name)
    for name in ABC
    for part in ("'collections' has no attribute '%s'", "import name '%s' from 'collections'")
)


def since(error):
    """Return what to use in place of something that only older Pythons and libraries had, or None."""
    if not isinstance(error, (AttributeError, ImportError, TypeError)):
        return None
    text = str(error)
    return next((advice for part, advice in OLDER if part in text), None)


PYTHON2 = (
    "pyros1: this looks like a program for Python 2, which ended in 2020. It runs here once it is converted: "
    "pip install fissix && fissix -w FILE does most of it."
)


def reason_for(error):
    """Return a hint about an error that is typical of old programs, or an empty text."""
    if is_python2(error):
        return PYTHON2
    advice = since(error)
    return "pyros1: this program was written for an older Python. %s." % advice if advice else ""


def take_over(name):
    """Import a module in place of the one of the same name in this folder.

    The folder has modules with the names that programs import first. They are only found if another sitecustomize
    precedes ours on PYTHONPATH, so that our modules have not been offered yet.
    """
    sys.path[:] = [each for each in sys.path if os.path.abspath(each or ".") != HERE]
    install()
    sys.modules.pop(name, None)
    __import__(name)


def install():
    """Offer the modules in this process, unless the environment selects stock's."""
    wanted = os.environ.get("PYROS1_ROSPY", "")
    if wanted == "stock" or any(type(each).__name__ in ("Waiting", "Finder") for each in sys.meta_path):
        return
    if wanted not in ("", "pyros1"):
        sys.stderr.write("pyros1: PYROS1_ROSPY is '%s', not 'pyros1' or 'stock': it is ignored\n" % wanted)
    if PathFinder in sys.meta_path:
        sys.meta_path.insert(sys.meta_path.index(PathFinder), Folders())
    if wanted == "pyros1":
        try:
            from pyros1.drop_in.finder import install

            install()
        except (ImportError, SyntaxError):
            sys.meta_path.append(Waiting())
    else:
        sys.meta_path.append(Waiting())
    if sys.version_info[0] == 2:
        return
    show = sys.excepthook

    def excepthook(kind, error, traceback):
        show(kind, error, traceback)
        word = reason_for(error)
        if word:
            sys.stderr.write(word + "\n")

    sys.excepthook = excepthook
