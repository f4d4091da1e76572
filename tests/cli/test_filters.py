"""What expressions of filters may use beside the message."""

from __future__ import annotations

import pytest

from pyros1.cli.shared.filters import filter_expression
from pyros1.ground.expressions import ExpressionError
from pyros1.ground.timing import Time
from pyros1.msgs.std_msgs.msg import String


def test_print(capsys: pytest.CaptureFixture[str]) -> None:
    names = {"m": String("a\x1b[2Jb"), "topic": "/t", "t": Time(1, 0)}
    assert filter_expression("print(topic, m.data, sep='|')")(names) is None
    assert filter_expression("print('%.1f' % t.to_sec(), end='') or m.data")(names)
    assert capsys.readouterr().out == "/t|a\\x1b[2Jb\n1.0"


def test_times() -> None:
    names = {"m": None, "t": Time(5, 0)}
    assert filter_expression("t - rospy.Time(3) == rospy.Duration(secs=2) and t > genpy.Time(1, 5)")(names)
    assert filter_expression("rospy.Time.now() > t and rospy.get_time() > 1 and time.time() > 1")(names)


@pytest.mark.parametrize("text", ["rospy.init_node('x')", "genpy.message", "time.sleep(9)", "os.getcwd()", "rospy()"])
def test_nothing_else(text: str) -> None:
    with pytest.raises(ExpressionError):
        filter_expression(text)({"m": None})
