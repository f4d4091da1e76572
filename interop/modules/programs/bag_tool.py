"""The progress that the tool rosbag prints."""

import io
import os
from contextlib import redirect_stdout

import rosbag.rosbag_main as tool


for path in ("/some/long/folder/with/a_long_file_name_indeed.bag", "abcdef.bag"):
    for columns in (45, 50, 52, 55, 60, 70, 80, 100):
        os.environ["COLUMNS"] = str(columns)
        for total in (0, 1, 1000, 1024, 1000 * 1024, 1024**2, 1024**3, 10**12, 10**15):
            with redirect_stdout(io.StringIO()) as out:
                meter = tool.ProgressMeter(path, total + 1, 1000.0)
                meter.step(total // 3)
                meter.step(total // 3, True)
                meter.step(total, force_update=True)
                meter.finish()
            print(columns, total, repr(out.getvalue()).replace("00:01", "00:00"))
print(tool.ProgressMeter.terminal_width())
