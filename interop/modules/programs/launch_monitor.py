"""Processes and the process monitor of roslaunch.pmon, with processes of the program's own."""

import sys
import time

import roslaunch.pmon as pmon
from roslaunch.core import RLException
from roslaunch.pmon import (
    DeadProcess,
    Process,
    ProcessListener,
    ProcessMonitor,
    pmon_shutdown,
    shutdown_process_monitor,
    start_process_monitor,
)


def t(title, call, *arguments, **named):
    try:
        found = repr(call(*arguments, **named))
    except Exception as error:
        found = f"{type(error).__name__}: {error}"
    print(f"{title} {found}")


def waits(process):
    found = process.should_respawn()
    return found is not False and abs(round(found, 1))


class Record:
    """Keeps what other threads print, which may end up in any order."""

    def __init__(self):
        self.texts = []

    def write(self, text):
        if text.strip():
            self.texts.append(text.strip())

    def flush(self):
        pass

    def show(self):
        sys.__stdout__.write(f"{sorted(self.texts)}\n")
        self.texts.clear()


for kw in (
    {},
    {"respawn": True},
    {"respawn": True, "respawn_delay": 2.5},
    {"respawn": False, "respawn_delay": 3},
    {"required": True},
    {"respawn": True, "required": True},
):
    p = Process("pkg", "name", ["a", "b"], {"X": "1"}, **kw)
    print(
        kw,
        p.package,
        p.name,
        p.args,
        p.env,
        p.respawn,
        p.respawn_delay,
        p.required,
        p.exit_code,
        p.spawn_count,
        p.time_of_death,
    )
    t("str", str, p)
    for c in (None, 0, 1, -9, 255):
        p.exit_code = c
        p.pid = 5
        t("info", p.get_info)
        t("alive", p.is_alive)
        t("respawn", waits, p)
        t("desc", p.get_exit_description)
    d = DeadProcess(p)
    t(
        "dead",
        lambda: (d.package, d.name, d.args, d.env, d.respawn, d.respawn_delay, d.required, d.exit_code, d.spawn_count),
    )
    t("info", d.get_info)
    t("alive", d.is_alive)
    t("desc", d.get_exit_description)
    t("start", d.start)
    t("stop", d.stop, [])
    t("start", p.start)
    t("start", lambda: p.spawn_count)
    t("stop", p.stop)
    t("stop", p.stop, [])
    for i in range(3):
        p.start()
        t("again", lambda: (p.spawn_count, p.is_alive(), waits(p)))


def until(condition):
    """Wait for what the monitor's thread does; nothing else prints meanwhile."""
    end = time.monotonic() + 10
    while not condition() and time.monotonic() < end:
        time.sleep(0.005)


class Mine(Process):
    """A process that runs while `runs` is true."""

    def __init__(self, name, **named):
        super().__init__("package", name, [], {}, **named)
        self.runs = True
        self.pid = 77

    def start(self):
        super().start()
        print(f"start {self.name}")
        self.exit_code = None
        self.runs = True
        return True

    def is_alive(self):
        return self.runs or super().is_alive()

    def stop(self, errors=None):
        print(f"stop {self.name} {errors}")
        self.runs = False

    def end(self, code):
        self.exit_code = code
        self.runs = False


class Listener(ProcessListener):
    def process_died(self, name, code):
        print(f"died {name} {code}")


def ended(monitor):
    return monitor.get_process_names_with_spawn_count()[1]


t("does nothing", ProcessListener().process_died, "name", 1)

# One that does not watch
monitor = ProcessMonitor()
print(monitor.name, monitor.is_shutdown, monitor.is_alive(), monitor.daemon)
t("jobs", monitor.has_main_thread_jobs)
t("jobs", monitor.do_main_thread_jobs)
t("spin", monitor.mainthread_spin_once)
a, b = Mine("a"), Mine("b")
t("listener", monitor.add_process_listener, Listener())
t("register", monitor.register, a)
t("register", monitor.register, b)
t("core", monitor.register_core_proc, Mine("core"))
t("twice", monitor.register, Mine("a"))
t("names", monitor.get_active_names)
t("counts", monitor.get_process_names_with_spawn_count)
t("has", lambda: [monitor.has_process(name) for name in ("a", "z", "core", "", None)])
t("get", lambda: [monitor.get_process(name) is a for name in ("a", "b", "z")])
t("get", monitor.get_process, "z")
t("unregister", monitor.unregister, b)
t("unregister", monitor.unregister, b)
t("kill", monitor.kill_process, "z")
t("kill", monitor.kill_process, "a")
t("kill", monitor.kill_process, 5)
t("names", monitor.get_active_names)
t("complete", monitor.registrations_complete)
t("late", monitor.register, Mine("late"))
t("shutdown", monitor.shutdown)
print(monitor.is_shutdown, monitor.is_alive(), monitor.get_active_names())
t("spin", monitor.mainthread_spin_once)
t("register", monitor.register, a)
t("again", monitor.shutdown)

# One that watches
sys.stdout = record = Record()
monitor = start_process_monitor()
print(monitor.is_alive(), monitor.name.rstrip("0123456789"), type(monitor).__name__)
monitor.add_process_listener(Listener())
for number, code in enumerate((3, 0, None, -9)):
    monitor.register(Mine(f"stays{number}"))
    process = Mine(f"ends{number}")
    monitor.register(process)
    process.end(code)
    until(lambda: len(ended(monitor)) == number + 1)
    record.show()
t("names", monitor.get_active_names)
t("counts", monitor.get_process_names_with_spawn_count)
t("has", monitor.has_process, "ends1")
again = Mine("again", respawn=True)
monitor.register(again)
for number in (1, 2):
    again.end(7)
    until(lambda: again.spawn_count == number and again.runs)
    record.show()
    t("counts", monitor.get_process_names_with_spawn_count)
needed = Mine("needed", required=True)
monitor.register(needed)
needed.end(4)
monitor.join(10)
record.show()
print(monitor.is_alive(), monitor.is_shutdown)
t("spin", monitor.mainthread_spin_once)
t("register", monitor.register, Mine("later"))
t("core", monitor.register_core_proc, Mine("later"))

# Their ends
monitor = start_process_monitor()
monitor.register(Mine("x"))
t("jobs", monitor.has_main_thread_jobs)
print(shutdown_process_monitor(monitor), monitor.is_alive(), monitor.is_shutdown)
print(shutdown_process_monitor(monitor), shutdown_process_monitor(None))
monitor = ProcessMonitor("mine")
process = Mine("only")
monitor.register(process)
monitor.registrations_complete()
process.end(0)
monitor.start()
monitor.mainthread_spin()
monitor.join(10)
record.show()
print(monitor.name, monitor.is_shutdown, monitor.is_alive(), monitor.get_process_names_with_spawn_count())
monitor = ProcessMonitor("run in this thread")
process = Mine("only")
monitor.register(process)
monitor.registrations_complete()
process.end(None)
t("run", monitor.run)
print(monitor.is_shutdown, monitor.get_process_names_with_spawn_count())


class Bad(Mine):
    def stop(self, errors=None):
        print(f"bad {errors}")
        raise ValueError("it does not stop")


monitor = start_process_monitor()
monitor.register(Mine("good"))
bad = Bad("bad")
monitor.register(bad)
monitor.register(Mine("better"))
t("kill", monitor.kill_process, "bad")
monitor.shutdown()
monitor.join(10)
record.show()
print(monitor.is_alive())
bad.end(0)
monitor = start_process_monitor()
monitor.register(Mine("last"))
pmon_shutdown()
monitor.join(10)
record.show()
print(monitor.is_shutdown, monitor.is_alive())
print(issubclass(pmon.FatalProcessLaunch, RLException), pmon.logger, pmon.FatalProcessLaunch("text"))
record.show()
