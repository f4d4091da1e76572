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
    "bag record": {
        "%prog /odom /scan -O run": "two topics into run.bag",
        "%prog -a -x '/camera/.*' -o day": "all but some, into day_<date>.bag; new topics too",
        "%prog -a --lz4 --split --duration 10m --max-splits 6": "the last hour, in files of ten minutes",
        "%prog -a --snapshot --snapshot-duration 60": "the last minute, when somebody calls ~snapshot",
    },
    "bag play": {
        "%prog run.bag": "at the pace of the recording; space pauses, s steps",
        "%prog --clock -r 0.5 -s 60 -u 10 run.bag": "ten seconds in slow motion, with simulated time",
        "%prog run.bag --topics /scan /tf /tf_static": "some topics",
        "%prog a.bag b.bag /scan:=/old/scan": "two bags together, one topic renamed",
    },
    "bag info": {
        "%prog run.bag": "what a bag holds",
        "%prog -y -k topics[0].type run.bag": "one value, for scripts",
        "%prog --json run.bag": "for programs",
    },
    "bag reindex": {"%prog run.bag.active": "save a bag that was not closed"},
    "bag filter": {
        "%prog run.bag out.bag \"topic == '/odom' and m.twist.twist.linear.x > 1\"": "by an expression",
        "%prog run.bag out.bag --topics '/camera/*,/tf' --from 10 --to -5": "topics, and a part of the time",
    },
    "bag merge": {"%prog all.bag a.bag b.bag": "by time"},
    "bag split": {"%prog run.bag --duration 5m --repeat-latched": "into run_0.bag, run_1.bag, ..."},
    "bag rename-topic": {
        "%prog run.bag out.bag /scan /front/scan": "one topic",
        "%prog run.bag out.bag /robot1/ /robot2/": "all topics of a namespace",
    },
    "bag retime": {
        "%prog run.bag out.bag --offset -3600": "an hour earlier",
        "%prog run.bag out.bag --header-stamp": "as the messages' headers say",
    },
    "bag export": {
        "%prog run.bag --format csv --topics /odom,/imu": "tables run_csv/odom.csv and run_csv/imu.csv",
        "%prog run.bag -o - --format jsonl | jq .message": "lines of JSON for other programs",
        "%prog run.bag --format images -o frames": "image files, named by their stamps",
        "%prog run.bag -o camera.mp4 --topics /camera/image_raw --from 10 --to 20": "a video",
        "%prog a.bag b.bag -o run.mcap": "two bags for Foxglove",
        "%prog run.bag -o run.mcap --ros1": "the messages unchanged, as `mcap convert` does",
        "%prog run.bag --format ros2": "for `ros2 bag play run_ros2`",
    },
    "bag import": {"%prog run.mcap -o run.bag": "of ROS 1 or ROS 2", "%prog rosbag2_folder": "into rosbag2_folder.bag"},
    "bag compress": {"%prog --lz4 *.bag": "in place, with backups"},
    "bag fix": {"%prog old.bag new.bag rules.bmr": "with rules made by `check -g rules.bmr`"},
}
