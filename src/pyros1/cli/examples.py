"""Examples that `--help` ends with: verb -> command line, with ``%prog`` for program and verb -> what it does."""

from __future__ import annotations

EXAMPLES: dict[str, dict[str, str]] = {
    "topic list": {
        "%prog": "all topics",
        "%prog -v /robot1": "with types and numbers of publishers, those below /robot1",
        "%prog --json": "for programs",
    },
    "topic info": {"%prog /chatter": "its type, publishers and subscribers"},
    "topic type": {"%prog /pose/header/stamp": "also of a field"},
    "topic find": {
        "%prog std_msgs/String": "topics of that type",
        "%prog --like scan": "topics whose name or type looks like it",
    },
    "topic echo": {
        "%prog /pose": "print what comes",
        "%prog -n 1 /pose/pose/position": "a field of one message",
        "%prog -p /odom > odom.csv": "rows for a spreadsheet",
        "%prog --filter 'm.ranges[0] < 1' /scan": "only some",
        "%prog --json /odom > odom.jsonl": "lines that `topic pub -f` plays again",
    },
    "topic hz": {"%prog /scan": "how often messages come", "%prog /a /b": "a table of several topics"},
    "topic bw": {"%prog /image": "bytes per second"},
    "topic delay": {"%prog /image": "how old messages are when they come"},
    "topic pub": {
        "%prog /vel_cmd std_msgs/Float64 1.0": "publish once, and stay for those who come later",
        "%prog -r 10 /cmd_vel geometry_msgs/Twist '{linear: {x: 0.1}}'": "ten times a second",
        "%prog -1 /goal geometry_msgs/PoseStamped '{header: auto}'": "once, and end",
        "%prog -f odom.jsonl /odom nav_msgs/Odometry": "what `topic echo --json` wrote",
    },
    "topic plot": {
        "%prog /velocity/data": "one curve in the terminal",
        "%prog /imu/linear_acceleration/x:y:z": "three fields of one message",
    },
}
