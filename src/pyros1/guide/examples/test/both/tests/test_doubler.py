"""Tests doubler.py with pytest. Each test has its own master, and everything that it starts is stopped afterwards.

python3 -m pytest my_package/tests
"""

import pytest


@pytest.fixture
def doubled(ros_run, ros_node, ros_listen):
    """Return a function that sends a number to the doubler, and returns the number that the doubler publishes."""
    output = ros_listen("output", "std_msgs/Float64")
    ros_run("my_package", "doubler.py")
    sender = ros_node("sender").advertise("input", "std_msgs/Float64", latch=True)

    def double(number):
        sender.publish(data=number)  # latched, in case the doubler subscribes later
        return output.next(timeout=20.0).data

    return double


@pytest.mark.parametrize("number", [1.5, -3.0])
def test_a_number_is_doubled(doubled, number):
    assert doubled(number) == 2 * number


def test_numbers_are_doubled_in_their_order(doubled):
    assert [doubled(number) for number in range(5)] == [0, 2, 4, 6, 8]
