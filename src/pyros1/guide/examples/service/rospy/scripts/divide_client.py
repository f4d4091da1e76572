#!/usr/bin/env python3
"""Calls the service divide and prints its response.

pyros1 run my_package divide_client.py 7 2
"""

import argparse
import sys

import rospy
from my_package.srv import Divide


def main():
    parser = argparse.ArgumentParser(description="Calls the service divide.")
    parser.add_argument("dividend", type=float)
    parser.add_argument("divisor", type=float)
    arguments = parser.parse_args(rospy.myargv()[1:])  # without ROS arguments such as __name:=other
    rospy.init_node("divide_client", anonymous=True)
    try:
        rospy.wait_for_service("divide", timeout=10.0)  # s
        response = rospy.ServiceProxy("divide", Divide)(arguments.dividend, arguments.divisor)
    except (rospy.ROSException, rospy.ServiceException) as error:
        sys.exit(f"no answer: {error}")
    print(f"{arguments.dividend:g} / {arguments.divisor:g} = {response.quotient:g}")


if __name__ == "__main__":
    main()
