"""diagnostic_updater by pyros1, beyond what interop/modules/test_diagnostic_updater.py compares with stock's."""

from __future__ import annotations

from programs import run

JUMP = """
import rospy, diagnostic_updater
rospy.init_node("updates", disable_signals=True)
updater = diagnostic_updater.Updater()
updater.hwid = "none"
updater.publish = lambda found: print(len(found))
updater.update()
print("back")
updater.last_time = rospy.Time.now() + rospy.Duration(1000)  # as after a jump of simulated time
updater.update()
updater.update()
"""


def test_updates_go_on_when_simulated_time_begins_again(environ: dict[str, str]) -> None:
    assert run(JUMP, environ).splitlines() == ["back", "0"]
