#!/usr/bin/env python3
"""Calls the service divide and prints its response.

pyros1 run my_package divide_client.py 7 2
"""

import argparse
import sys

import pyros1
from pyros1.msgs.my_package.srv import Divide

parser = argparse.ArgumentParser(description="Calls the service divide.")
parser.add_argument("dividend", type=float)
parser.add_argument("divisor", type=float)

with pyros1.Node("divide_client", anonymous=True) as node:
    arguments = parser.parse_args(node.arguments.rest)  # without ROS arguments such as __name:=other
    try:
        node.wait_for_service("divide", timeout=10.0)  # s
        response = node.service("divide", Divide)(arguments.dividend, arguments.divisor)
    except pyros1.Error as error:
        sys.exit(f"no answer: {error}")
    print(f"{arguments.dividend:g} / {arguments.divisor:g} = {response.quotient:g}")
