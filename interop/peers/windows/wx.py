"""A stand-in for wxPython, as far as actionlib's axclient and axserver use it, without a window.

What the window would show is printed: ``TITLE | TEXT`` of a box, ``label | TEXT``, ``BUTTON | on``, ``message | TEXT``.
Each line of the standard input is the label of a button, which is pressed, or ``TITLE=TEXT``, typed into that box; its
``|`` stand for ends of lines. The end of the input closes the window.
"""

from __future__ import annotations

import queue
import sys
import threading
from collections.abc import Callable
from typing import Any

VERTICAL = EXPAND = OK = TE_MULTILINE = TE_READONLY = 0
EVT_BUTTON = EVT_TIMER = None
_SHORTER = 20
"""A timer's period is divided by this, for tests that are quick."""
_calls: queue.Queue[tuple[Callable[..., object], tuple[Any, ...]] | None] = queue.Queue()
_boxes: dict[str, TextCtrl] = {}
_buttons: dict[str, Button] = {}


def CallAfter(function: Callable[..., object], *arguments: object) -> None:
    """Call a function in the main loop."""
    _calls.put((function, arguments))


def MessageBox(text: str, title: str, _style: int) -> None:
    """Show a text."""
    print(f"message | {title} | {text}", flush=True)


class Window:
    """What is common to all."""

    def __init__(self, _parent: object = None, _number: int = -1, label: str = "", style: int = 0) -> None:
        self.label = label
        self.enabled = True

    def __getattr__(self, name: str) -> Callable[..., None]:
        """Do nothing: sizes, colours."""
        if name not in ("Add", "SetSizer", "Layout", "Show", "SetBackgroundColour"):
            raise AttributeError(name)
        return lambda *_: None

    def Bind(self, _event: None, function: Callable[[None], object], timer: Timer | None = None) -> None:
        """Call a function when the button is pressed, or the timer expires."""
        self.function = function
        if timer is not None:
            timer.function = function

    def Enable(self) -> None:
        """Let it be pressed."""
        self._enable(True)

    def Disable(self) -> None:
        """Let it not be pressed."""
        self._enable(False)

    def _enable(self, on: bool) -> None:
        if on != self.enabled:
            self.enabled = on
            print(f"{self.label} | {'on' if on else 'off'}", flush=True)


Frame = Panel = StaticBox = Window


class StaticText(Window):
    """A label."""

    def SetLabel(self, text: str) -> None:
        """Change it."""
        if text != self.label:
            self.label = text
            print(f"label | {text}", flush=True)


class Button(Window):
    """A button."""

    def __init__(self, parent: object, number: int, label: str) -> None:
        super().__init__(parent, number, label)
        _buttons[label] = self


class TextCtrl(Window):
    """A box with a text; it is called as the frame around it."""

    text = ""

    def GetValue(self) -> str:
        """Return the text."""
        return self.text

    def SetValue(self, text: str) -> None:
        """Change the text."""
        if text != self.text:
            self.text = text
            print(f"{self.label} | {text!r}", flush=True)


class BoxSizer(Window):
    """A place for others."""

    def __init__(self, _direction: int) -> None:
        super().__init__()


class StaticBoxSizer(Window):
    """A place for a box, which gets the title of the frame."""

    def __init__(self, box: Window, _direction: int) -> None:
        super().__init__(label=box.label)

    def Add(self, box: TextCtrl, *_: int) -> None:
        """Take the box."""
        box.label = self.label
        _boxes[self.label] = box


class Colour(tuple[int, ...]):
    """A colour."""

    __slots__ = ()

    def __new__(cls, *parts: int) -> Colour:
        return super().__new__(cls, parts)


class Timer:
    """Calls a function again and again."""

    function: Callable[[None], object]

    def __init__(self, _frame: Window) -> None:
        self._over = threading.Event()

    def Start(self, milliseconds: int) -> None:
        """Begin."""
        threading.Thread(target=self._run, args=(milliseconds / 1000 / _SHORTER,), daemon=True).start()

    def _run(self, seconds: float) -> None:
        while not self._over.wait(seconds):
            CallAfter(self.function, None)

    def Stop(self) -> None:
        """End."""
        self._over.set()


class App:
    """The program."""

    def __init__(self) -> None:
        self.OnInit()

    def OnInit(self) -> bool:
        """Make the window; programs replace it."""
        raise NotImplementedError

    def MainLoop(self) -> None:
        """Make the calls of `CallAfter`, and what the standard input says, until its end."""
        threading.Thread(target=_read, daemon=True).start()
        for function, arguments in iter(_calls.get, None):
            try:
                function(*arguments)
            except Exception as error:  # noqa: BLE001  as wxPython, which goes on
                print(f"error | {type(error).__name__}", flush=True)


def _read() -> None:
    for line in sys.stdin:
        title, typed, text = line.rstrip("\n").partition("=")
        if typed:
            CallAfter(setattr, _boxes[title], "text", text.replace("|", "\n"))
        else:
            CallAfter(_press, title)
    _calls.put(None)


def _press(label: str) -> None:
    if _buttons[label].enabled:
        _buttons[label].function(None)
