"""The master through rosgraph.Master."""

import rosgraph, rosgraph.masterapi as m, os, socket, sys


def show(f):
    try:
        r = f()
        return (type(r).__name__, str(r).replace(os.environ["ROS_MASTER_URI"], "URI"))
    except OSError as e:
        return ("!", type(e).__name__, e.errno)  # ours say where the master was sought
    except Exception as e:
        return ("!", type(e).__module__, type(e).__name__, str(e), [c.__name__ for c in type(e).__mro__[1:3]])


M = rosgraph.Master("/me")
print(M.caller_id, rosgraph.Master("a/b").caller_id, M.master_uri == os.environ["ROS_MASTER_URI"])
calls = [
    lambda: M.getParam("nope"),
    lambda: M.getParam("/run_id") and 1,
    lambda: M.getParam(""),
    lambda: M.getParam(3),
    lambda: M.setParam("/x/y", {"a": 1}),
    lambda: M.getParam("/x"),
    lambda: M.hasParam("/x/y/a"),
    lambda: M.hasParam("/q"),
    lambda: M.deleteParam("/q"),
    lambda: M.deleteParam("/x/y"),
    lambda: M.searchParam("x"),
    lambda: M.searchParam("~"),
    lambda: M.searchParam("nope"),
    lambda: sorted(M.getParamNames())[:0],
    lambda: M.lookupNode("/nope"),
    lambda: M.lookupService("/nope"),
    lambda: M.getPublishedTopics(""),
    lambda: M.getPublishedTopics("/"),
    lambda: M.getSystemState()[2][:0],
    lambda: M.is_online(),
    lambda: type(M.getPid()),
    lambda: M.registerPublisher("/t1", "std_msgs/String", "http://localhost:9/"),
    lambda: M.registerSubscriber("/t1", "std_msgs/String", "http://localhost:9/"),
    lambda: M.registerService("/s1", "rosrpc://localhost:9", "http://localhost:9/"),
    lambda: M.lookupService("/s1"),
    lambda: M.lookupNode("/me"),
    lambda: M.unregisterService("/s1", "rosrpc://localhost:9"),
    lambda: M.unregisterPublisher("/t1", "http://localhost:9/"),
    lambda: M.unregisterSubscriber("/t1", "http://localhost:9/"),
    lambda: M.unregisterSubscriber("/t1", "http://localhost:9/"),
    lambda: M.subscribeParam("http://localhost:9/", "/z"),
    lambda: M.unsubscribeParam("http://localhost:9/", "/z"),
    lambda: M.registerPublisher("/t1", "bad", "x"),
    lambda: M.registerPublisher(1, 2, 3),
]
for c in calls:
    print(show(c))
s = socket.socket()
s.bind(("127.0.0.1", 0))
p = s.getsockname()[1]
s.close()
D = rosgraph.Master("/me", "http://127.0.0.1:%d/" % p)
print(
    show(lambda: D.getPid()),
    D.is_online(),
    m.is_online("http://127.0.0.1:%d/" % p),
    m.is_online(),
    rosgraph.is_master_online(),
)
print(
    show(lambda: rosgraph.Master("/me", "foo")),
    show(lambda: rosgraph.Master("/me", "foo:3").getPid()),
    show(lambda: rosgraph.Master("/me", "http://no.such.host.invalid:3").getPid()),
    show(lambda: m.is_online("bad")),
)
for a in "MasterException MasterFailure MasterError ROSMasterException Error Failure".split():
    print(
        a, [c.__name__ for c in getattr(m, a).__mro__], getattr(m, a) is m.MasterError, getattr(m, a) is m.MasterFailure
    )
