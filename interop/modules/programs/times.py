"""Times: what each operation gives, or raises."""

import copy
import itertools
import operator
import pickle
import random

from genpy import Duration, Time, TVal


def show(function):
    try:
        result = function()
    except Exception as error:
        return "!", type(error).__name__, "" if "number" in str(error) or "int" in str(error) else str(error)
    return type(result).__name__, str(result)


dice = random.Random(7)
values = [Time(), Duration(), Time(3, 5), Duration(-3, 5), Duration(1.5), Time(12345.678901234), Duration(-0.5)]
values += [TVal(1, 2), TVal(5), 0, 1, 3, -2, 2.5, -0.25, True, "x", None, [1]]
for _ in range(20):
    values.append(Time(dice.randrange(2**31), dice.randrange(10**9)))
    values.append(Duration(dice.randrange(-(2**31), 2**31), dice.randrange(10**9)))
compared = (operator.lt, operator.le, operator.gt, operator.ge, operator.eq, operator.ne)
for do in (operator.add, operator.sub, operator.mul, operator.truediv, *compared):
    for a, b in itertools.product(values, values):
        if isinstance(a, TVal) or isinstance(b, TVal):
            print(do.__name__, str(a), str(b), show(lambda: do(a, b)))
whole = [Duration(dice.randrange(-9, 9)) for _ in range(12)] + [Time(3), TVal(2), 3, 0, 2.0, -2.5, "x", None]
for do in (operator.floordiv, operator.mod, divmod):
    for a, b in itertools.product(whole, whole):
        if isinstance(a, Duration):
            text = show(lambda: do(a, b))
            print(do.__name__, str(a), str(b), text[:2] if text[0] == "!" else text[0])
for each in values:
    if isinstance(each, TVal):
        for name in ("to_sec", "to_nsec", "is_zero", "to_time", "__bool__", "__neg__", "__abs__"):
            print(name, str(each), show(lambda: getattr(each, name)()))
        print(repr(each), hash(each) == hash(copy.copy(each)), list(type(each).__slots__), each._slot_types)
        if type(each) is not TVal:
            print(pickle.loads(pickle.dumps(each)) == each, copy.deepcopy(each) == each, each.__getstate__())
for kind in (Time, Duration, TVal):
    for args in [(), (1,), (1, 2), (1.5,), (1.5, 1), (-1,), (-1.5,), (0, -1), (0, 10**10), (2**32,), (-(2**31) - 1,)]:
        print(kind.__name__, args, show(lambda: kind(*args)))
    for args in [
        (1, 2.5),
        (True,),
        (0, 2**40),
        (1.9999999999,),
        (0.1,),
        (1e9 + 0.123456789,),
        (-0.0,),
        (float("nan"),),
    ]:
        print(kind.__name__, args, show(lambda: kind(*args)))
    for number in [
        0,
        1,
        1.5,
        -1.5,
        1e9 + 0.123456789,
        2**33,
        True,
        -0.1,
        *(dice.uniform(-1e9, 1e9) for _ in range(50)),
    ]:
        print("from_sec", kind.__name__, number, show(lambda: kind.from_sec(number)))
    moment = kind(1, 2)
    for args in [(5, 6), (5, 10**9 + 6), (5, -6)]:
        print("set", args, show(lambda: moment.set(*args)), str(moment))
    moment.secs, moment.nsecs = 5, 3 * 10**9
    print(show(moment.canon), str(moment), show(lambda: moment.foo))
