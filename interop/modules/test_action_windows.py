"""axclient and axserver of actionlib_tools, unmodified, on stock's modules and on ours, with the same results.

A stand-in for wxPython prints what their windows would show, and presses the buttons: ``peers/windows/wx.py``.
"""

from __future__ import annotations

import itertools
import re
import time
from pathlib import Path

from faces import FACES, START
from harness import PEERS, SOURCE, Master, Process, until
from stock_programs import begin, link_modules

MASTERS = ("ours",)
TOOLS = "/usr/lib/actionlib_tools"
ACTION = "actionlib/TestAction"
CLIENTS = {"happy": [ACTION], "hasty": [ACTION], "unlucky": []}
"""Their arguments behind the action's name. Each sends one goal: a second one right behind the first races in stock."""
OMITTED = re.compile(r"\[|label . Disconnected|label . Goal is active")
"""Logs; what a client says until it has found the server; and what stock's misses if the server is quick."""
STEPS: list[tuple[str, list[str], list[tuple[str, str]]]] = [
    ("happy", [], [(client, "SEND GOAL . on") for client in CLIENTS]),
    ("happy", ["Goal=goal: seven", "SEND GOAL"], [("happy", "^message . Error serializing goal")]),
    ("happy", ["Goal=goal: 7", "SEND GOAL"], [("server", "Goal . 'goal: 7")]),
    ("server", ["Feedback=feedback: x", "SEND FEEDBACK"], [("server", "^message . Error serializing feedback")]),
    ("server", ["Feedback=feedback: 3", "SEND FEEDBACK"], [("happy", "Feedback . 'feedback: 3")]),
    ("server", ["Result=result: 9", "SUCCEED"], [("server", "Waiting"), ("happy", "CANCEL GOAL . off")]),
    ("hasty", ["Goal=goal: 8", "SEND GOAL"], [("server", "Goal . 'goal: 8")]),
    ("hasty", ["CANCEL GOAL"], [("server", "label . Preempt requested")]),
    ("server", ["PREEMPT"], [("server", "Waiting"), ("hasty", "CANCEL GOAL . off")]),
    ("unlucky", ["SEND GOAL"], [("server", "Goal . 'goal: 0")]),
    ("server", ["ABORT"], [("server", "Waiting"), ("unlucky", "CANCEL GOAL . off")]),
]
"""Who does what, and what both then show."""


def programs(face: str, master: Master, modules: Path) -> dict[str, Process]:
    """Start a server and its clients."""
    places = [str(PEERS / "windows"), *([str(START), str(SOURCE), str(modules)] if face == "ours" else [])]
    command = [f"{TOOLS}/axserver.py", f"/of_{face}", ACTION]
    started = {"server": begin(face, master, modules, command, PYTHONPATH=":".join(places))}
    started["server"].wait_line("PREEMPT . off")
    started["server"].wait_line("auto_start")  # now there are topics, which tell clients the type
    for client, words in CLIENTS.items():
        command = [f"{TOOLS}/axclient.py", f"/of_{face}", *words]
        started[client] = begin(face, master, modules, command, PYTHONPATH=":".join(places))
        started[client].wait_line("CANCEL GOAL . off")  # so that the next one is at the end of a goal
    return started


def do(face: dict[str, Process], who: str, words: list[str], shown: list[tuple[str, str]]) -> None:
    """Type and press buttons: those of the server until the result is shown.

    axserver forgets what is pressed after it shows a goal and before its other thread waits for buttons.
    """

    def is_shown() -> bool:
        return all(face[whom].unread(line) for whom, line in shown)

    def press() -> bool:
        for word in words:
            face[who].write(word)
        end = time.monotonic() + 2.0
        while not is_shown() and time.monotonic() < end:
            time.sleep(0.02)
        return is_shown()

    if who == "server":
        until(press, f"{words} shows {shown}", 60.0)
    else:
        for word in words:
            face[who].write(word)


def test_goals_are_sent_and_answered(launcher: Master, tmp_path: Path) -> None:
    modules = link_modules(tmp_path / "modules", ["actionlib_tools"])
    faces = [programs(face, launcher, modules) for face in FACES]
    for who, words, shown in STEPS:
        for face in faces:
            do(face, who, words, shown)
        for face, (whom, line) in itertools.product(faces, shown):
            face[whom].wait_line(line)
    said = []
    for face in faces:
        for process in face.values():
            assert process.child.stdin is not None
            process.child.stdin.close()
            assert process.wait() == 0
        shown = {
            name: [line for line in each.lines if not OMITTED.match(line)]
            for name, each in face.items()
            if name in CLIENTS
        }
        said.append({name: [re.sub(", not str .*", "", line) for line in lines] for name, lines in shown.items()})
    assert said[0] == said[1]
    for client, end in {"happy": "SUCCEEDED", "hasty": "PREEMPTED", "unlucky": "ABORTED"}.items():
        assert f"label | Goal finished with status: {end}" in said[0][client]
