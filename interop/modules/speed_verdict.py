"""The figures of `speed.md` with a ratio for each row: how near rospy on ours comes to our Node."""

from __future__ import annotations

import re

GOAL = 0.9
_HIGHER = ("messages/s", "messages/s each", "MB/s", "calls/s")
_LOWER = ("us", "ms", "kB", "% of a core")
_ROW = re.compile(r"\| (?P<work>[^|]+) \| (?P<unit>[^|]+) \| (?P<ours>[^|]+) \| (?P<node>[^|]+) \| [^|]+ \|")


def with_ratios(text: str) -> str:
    """Return the page's text with a column of ratios, more is better, and how many rows are below the goal."""
    lines, rows, below, apart = [], 0, [], []
    for line in text.splitlines():
        match = _ROW.fullmatch(line)
        if match is None:
            lines.append(line + "---|" if line.startswith("|---") else line)
        elif match["work"] == "work":
            lines.append(f"{line} ours / Node |")
        elif match["unit"] in (*_HIGHER, *_LOWER):
            ours, node = _numbers(match["ours"]), _numbers(match["node"])
            ratio = ours[0] / node[0] if match["unit"] in _HIGHER else node[0] / ours[0]
            rows += 1
            if round(ratio, 2) < GOAL:
                below.append(match["work"])
                if ours[2] < node[1] or node[2] < ours[1]:
                    apart.append(match["work"])
            lines.append(f"{line} {ratio:.2f} |")
        else:
            lines.append(f"{line} |")
    but = f" but {'; '.join(apart)}" if apart else ""
    lines += [
        "",
        "The ratio is that of the medians, inverted where less is better; rows that have no better or worse have none.",
        f"The goal is {GOAL}. {len(below)} of {rows} rows of these runs are below it: {'; '.join(below)}.",
        f"The two ranges overlap in all of these{but}.",
    ]
    return "\n".join(lines) + "\n"


def _numbers(cell: str) -> tuple[float, float, float]:
    """Return median, least and most."""
    median, least, most = (float(each) for each in re.findall(r"-?[\d.]*\d", cell.replace(",", "").replace("..", " ")))
    return median, least, most
