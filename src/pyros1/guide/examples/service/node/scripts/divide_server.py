#!/usr/bin/env python3
"""Provides the service divide. Division by zero is rejected with an error.

pyros1 run my_package divide_server.py
pyros1 service call divide 7 2          calls it, in another terminal
pyros1 run my_package divide_client.py 7 2
"""

import pyros1
from pyros1.msgs.my_package.srv import Divide, DivideResponse  # generated from srv/Divide.srv without a build step


def divide(request):
    if request.divisor == 0.0:
        raise pyros1.ServiceRefusal("the divisor is 0")
    return DivideResponse(quotient=request.dividend / request.divisor)


with pyros1.Node("divide_server") as node:
    node.advertise_service("divide", Divide, divide)
    node.spin()
