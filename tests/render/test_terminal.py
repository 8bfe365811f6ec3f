"""What the terminal shows: nothing of a file is obeyed, no figure is cut."""

import io

import numpy as np
import pytest

from scara_iso import analyze, read_table
from scara_iso.render.terminal import open_console, show
from scara_iso.reporting import sparkline
from scara_iso.reporting.analysis import analysis_report
from scara_iso.reporting.shared.blocks import Notice, Section, Strip, Table, Text
from scara_iso.reporting.shared.digits import printable

HOSTILE = "[bold red]x[/] \x1b[31mred \x07 \u202egnp.exe \u2028 :smile: [link=http://e]e[/link]"


def shown(*blocks, heading="", width=80):
    stream = io.StringIO()
    console = open_console(stream)
    console.width = width
    show((Section(heading, blocks),), console)
    return stream.getvalue()


@pytest.mark.parametrize(
    "block",
    [
        Text(HOSTILE),
        Table(("a", HOSTILE), ((HOSTILE, HOSTILE),), HOSTILE),
        Strip(HOSTILE, np.arange(3.0), HOSTILE),
        Notice("error", HOSTILE, HOSTILE, HOSTILE),
    ],
    ids=lambda block: type(block).__name__,
)
@pytest.mark.parametrize("width", [200, 30])
def test_text_of_a_file_is_shown_and_not_obeyed(block, width):
    text = shown(block, heading=HOSTILE, width=width)
    for character in "\x1b\x07\u202e\u2028":
        assert character not in text
    assert "[bold" in text
    assert ":smile:" in text


def test_printable_keeps_what_people_write():
    assert printable("Prüfer: Çelik µm ± 2 °C") == "Prüfer: Çelik µm ± 2 °C"
    assert printable("a\tb\x00") == "a\\tb\\x00"


def test_a_table_too_wide_is_shown_row_by_row():
    table = Table(("axis", "first", "second"), (("X", "1.234567", "2.345678"), ("Y", "", "3")))
    wide, narrow = shown(table, width=60), shown(table, width=20)
    assert "1.234567" in wide.splitlines()[2]
    assert narrow.splitlines() == [
        "  X", "    first   1.234567", "    second  2.345678", "  Y", "    second  3", "",
    ]  # fmt: skip


def test_long_text_wraps_without_trailing_blanks():
    text = shown(Text("word " * 40), width=40)
    assert all(len(line) <= 40 and not line.endswith(" ") for line in text.splitlines())


def test_sparkline():
    assert sparkline(np.array([0.0, 1.0, 2.0]), "abc", 80) == "abc"
    assert sparkline(np.array([5.0, 5.0]), "abc", 80) == "bb"
    assert sparkline(np.repeat([0.0, 10.0], 50), "abc", 10) == "aaaaaccccc"


def test_the_largest_of_several_angles_is_named():
    rng = np.random.default_rng(9283)
    rows = [
        f"{cycle},P{pose},{pose * value:.4f}"
        for pose in (1, 2, 3)
        for cycle, value in enumerate(rng.normal(0, 0.01, 31), start=1)
    ]
    text = "\n".join(["# unit_theta: deg", "cycle,pose,theta", *rows])
    table = io.BytesIO(text.encode())
    opening = analysis_report(analyze(read_table(table)))[0]
    (headline,) = (block for block in opening.blocks if isinstance(block, Text) and block.parts)
    assert "at P3, the largest of 3 poses" in headline.text


def test_a_screen_shows_a_part_and_counts_the_rest():
    rows = tuple((str(k), "1") for k in range(103))
    assert "\n  3 more; --json gives them all" in shown(Table(("a", "b"), rows))
    notices = [Notice("info", "code", "", f"notice {k}") for k in range(105)]
    text = shown(*notices, Text("the end", "strong"))
    assert "notice 99" in text
    assert "notice 100" not in text
    assert "  5 more; --json gives them all\n  the end" in text
    assert "7 more; --json" in shown(*[Text(f"note {k}", "quiet") for k in range(13)])
    assert "--json gives all" in shown(Text("word " * 1000))


def test_of_many_poses_the_first_are_shown_and_what_follows_them():
    sections = [
        Section(f"{name} of P{k}", (Text(f"{name} {k}"),), f"P{k}")
        for k in range(12)
        for name in ("figures", "course")
    ]
    stream = io.StringIO()
    show((*sections, Section("findings", (Text("last"),))), open_console(stream))
    text = stream.getvalue()
    assert "course 9" in text
    assert "figures 10" not in text
    assert text.index("2 more like these; --json gives them all") < text.index("last")
