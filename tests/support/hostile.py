"""What a file or a wire could say to do harm where it is shown: for the tests of every output."""

import re
from pathlib import Path

import openpyxl

from scara_iso.reporting.shared.stated import FIELDS

FORMULAS = (
    "=1+1",
    "+1+1",
    "-1+1",
    "@SUM(1)",
    "\t=1+1",
    "\r=1+1",
    " =1+1",
    "\n@SUM(1)",
    "=cmd|' /C calc'!A0",
    '=HYPERLINK("http://example.invalid","click")',
    'a";=1+1;"',
    "a,=1+1",
    "a;=1+1",
    "a\n=1+1",
    "\uff1d1+1",
    "\uff201+1",
    "-2 mm",
)
"""Text that a spreadsheet could take for a formula."""

TEXTS = (
    *FORMULAS,
    "[red]x[/red]",
    "[/]",
    "[link=http://example.invalid]x[/link]",
    "<script>alert(1)</script>",
    "</style><img src=x onerror=alert(1)>",
    "]]><!--",
    "&lt;b&gt; &amp;",
    "a\x00b",
    "\x1b[2J\x1b[31mred\x1b]0;title\x07",
    "\x9b31m",
    "\u202eevil\u202c",
    "\u2066x\u2069",
    "one\ntwo\r\nthree\u2028four",
    "x" * 40_000,
    "\"quoted\" 'twice' `thrice`",
    "\ud800 and \udfff",
    "\ufffe\uffff",
    "{{ 7*7 }} {% raw %}",
    "| a | b |\n|---|---|",
    "$(reboot) `reboot` %PATH%",
    "../../etc/passwd",
    "[x](javascript:alert(1)) ![i](http://example.invalid/x.png)",
    "WWW.example.invalid https://example.invalid a@example.invalid",
    "$\\frac{1}{$ $x$",
    "_x0041__x001B_[2J",
    "\U000e0041\u00ad\u200b",
    "1. one",
    "---",
)
"""Every hostile text."""

WORDS = tuple(text for text in TEXTS if "\0" not in text and "\ud800" not in text)
"""Those that a shell can hand to a program."""

_MODEL = Path(__file__).parents[2] / "examples" / "fum_scara.toml"
_UNWRITABLE = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\ud800-\udfff\ufffe\uffff]|_(?=x[0-9A-Fa-f]{4}_)"
)


def table(path, *, texts=TEXTS, poses=None, cycles=4, shift=0.0):
    """Write a workbook whose every field, key, pose and covariate is hostile; return its path.

    A workbook can hold every control character. Poses and covariates have a letter in front
    where a reader would refuse them.
    """
    texts = [text[:30_000] for text in texts]
    keys = [key for named in FIELDS.values() for key in named]
    head = [(key, texts[k % len(texts)]) for k, key in enumerate(keys)]
    head += [(f"free {k}", text) for k, text in enumerate(texts)]
    head += [(f"k{k}{re.sub('[:=]', '', text[:30])}", "a key") for k, text in enumerate(texts)]
    names = [f"c{k}{text[:30]}" for k, text in enumerate(texts)]
    labels = [f"p{k}{text[:30]}" for k, text in enumerate(texts)] if poses is None else poses
    rows = [
        (label, n, n * 0.001 + shift, n % 3 * 0.001 + shift, *[-n / 2] * len(names))
        for label in labels for n in range(1, cycles + 1)
    ]  # fmt: skip
    book = openpyxl.Workbook()
    column = ("pose", "cycle", "X", "Y", *names)
    for row in (("unit", "mm"), ("resolution", 0.001), *head, column, *rows):
        book.active.append([_cell(v) if isinstance(v, str) else v for v in row])
    for row in book.active:
        for cell in row:
            cell.data_type = "s" if isinstance(cell.value, str) else cell.data_type
    book.save(path)
    return path


def _cell(text):
    return _UNWRITABLE.sub(lambda found: f"_x{ord(found[0]):04X}_", text)


def model(path, name):
    """Write the example's model for a robot of that name; return its path."""
    text = re.sub(r"(?m)^name = .*", lambda _: f"name = {toml(name)}", _MODEL.read_text("utf-8"))
    path.write_text(text, encoding="utf-8")
    return path


def toml(text):
    """Return a string of TOML."""
    return re.sub(r"[^ -~]|[\"\\\\]", lambda found: f"\\U{ord(found[0]):08X}", text).join('""')


def sweep(path):
    """Write a measured sweep under hostile comments and beside a hostile column."""
    rows = [f"2.65e-4,{load},12,{-2e-3 / load:.3e},x" for load in range(2, 9)]
    texts = [ascii(text)[1:-1] for text in TEXTS if len(text) < 100]
    head = [*(f"# {text}" for text in texts), "Im,IL,arcmin,deviation_rad,[red]x<b>"]
    path.write_text("\n".join([*head, *rows]) + "\n", encoding="utf-8")
    return path
