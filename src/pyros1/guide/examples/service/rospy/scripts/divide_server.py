#!/usr/bin/env python3
"""Provides the service divide. Division by zero is rejected with an error.

pyros1 run my_package divide_server.py
pyros1 service call divide 7 2          calls it, in another terminal
pyros1 run my_package divide_client.py 7 2
"""

import rospy
from my_package.srv import Divide, DivideResponse  # generated from srv/Divide.srv


def divide(request):
    if request.divisor == 0.0:
        raise rospy.ServiceException("the divisor is 0")
    return DivideResponse(quotient=request.dividend / request.divisor)


if __name__ == "__main__":
    rospy.init_node("divide_server")
    rospy.Service("divide", Divide, divide)
    rospy.spin()
