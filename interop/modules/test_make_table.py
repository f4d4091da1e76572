"""The parts of `make_table.py`: what counts as tested, and the verdict on speed."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

from speed_verdict import with_ratios
from uses import used_names


def test_names_count_in_code_and_in_programs_in_strings_only(tmp_path: Path) -> None:
    (tmp_path / "a.py").write_text(
        '"""rospy.in_docs of rospy.timer"""\n'
        "import rospy.core  # in_comment\n"
        "word = 'in_word'\n"
        "text = '''\nimport genpy\nprint(genpy.in_program, f\"{rospy.in_inner(1)} in_text\")\n'''\n"
        "rospy.core.in_code(1)\n"
        "def test():\n    rospy.rostime.also\n"
    )
    (tmp_path / "b.py").write_text("import tf\ntf.elsewhere\n")
    used = used_names(
        [tmp_path / "a.py", tmp_path / "b.py"], ["rospy", "rospy.core", "rospy.rostime", "rospy.timer", "genpy"]
    )
    assert {"in_code", "in_program", "in_inner", "also"} <= used["rospy"]
    assert not {"in_docs", "in_comment", "in_word", "in_text", "elsewhere"} & used["rospy"]
    assert used["rospy"] == used["rospy.core"] == used["genpy"] == used["rospy.rostime"]
    assert used["rospy.timer"] == set()


def test_ratios_are_those_of_medians_turned_round_where_less_is_better() -> None:
    page = with_ratios(
        "| work | unit | a | b | c |\n|---|---|---|---|---|\n"
        "| fast | calls/s | 1,200 (900..1,300) | 1,000 (950..1,100) | 1 (1..1) |\n"
        "| slow | us | 20 (18..30) | 10 (9..12) | 1 (1..1) |\n"
        "| unsure | MB/s | 8 (5..12) | 10 (9..11) | 1 (1..1) |\n"
        "| other | threads | 5 (5..5) | 5 (5..5) | 5 (5..5) |\n"
    )
    rows = page.splitlines()
    assert [row.rpartition(" | ")[2] for row in rows[:1] + rows[2:5]] == ["ours / Node |", "1.20 |", "0.50 |", "0.80 |"]
    assert rows[5].endswith(" | |")
    assert "2 of 3 rows of these runs are below it: slow; unsure." in page
    assert "overlap in all of these but slow." in page
