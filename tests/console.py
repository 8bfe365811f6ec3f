"""Play the console blocks of a page: each command in order, in one folder, beside examples/.

``python tests/console.py docs/tutorial.md`` writes the outputs of today's program into the page;
a line ``...`` in an output stands for lines that are left out.
"""

import contextlib
import io
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from difflib import SequenceMatcher
from pathlib import Path
from unittest import mock

from scara_iso.commands import main
from scara_iso.recorder.ports.device import Device

ROOT = Path(__file__).parents[1]
BLOCK = re.compile(r"(?<=^```console\n).*?(?=^```)", re.MULTILINE | re.DOTALL)
WIDTH = "80"
LEFT_OUT = "..."
CABLES = (
    Device("/dev/ttyS0", "ttyS0", None, None, None),
    Device("/dev/ttyUSB0", "USB-Serial Controller", "067b:2303", None, "1-2"),
)
"""The serial ports of the machine that the pages show."""

BEHIND = []
"""What a page has begun by a command with ``&``, and is over when the page is."""


class Screen(io.StringIO):
    """A terminal of which the last picture counts."""

    def isatty(self):
        return True

    def picture(self):
        last = self.getvalue().rpartition("\x1b[2K")[2]
        return re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", last)


def played(page):
    """Return the page as its commands make it today; COLUMNS and the folder are the caller's."""
    shown = BLOCK.sub(lambda block: _played_block(block[0]), page)
    while BEHIND:
        assert BEHIND.pop().wait(60) == 0
    return shown


def _played_block(block):
    parts = re.split(r"^(\$ .*\n)", block, flags=re.MULTILINE)
    assert not parts[0], f"a console block begins with a command: {parts[0]!r}"
    said = []
    for line, shown in zip(parts[1::2], parts[2::2], strict=True):
        output = run(line[2:].strip())
        said += [line, shown if alike(shown, output) else renewed(shown, output)]
    return "".join(said)


def alike(shown, output):
    """Say whether an output is the one shown, with or without the lines left out."""
    kept = [re.escape(part) for part in re.split(rf"^{re.escape(LEFT_OUT)}\n", shown, flags=re.M)]
    return re.fullmatch("(?:.*\n)*?".join(kept), output) is not None


def renewed(shown, output):
    """Return today's output with the lines left out that are left out in the one shown."""
    lines = output.splitlines(keepends=True)
    kept, at = [], 0
    for part in re.split(rf"^{re.escape(LEFT_OUT)}\n", shown, flags=re.M):
        length = part.count("\n")
        starts = range(at, len(lines) - length + 1)
        at = max(starts, key=lambda k: _likeness(part, lines[k : k + length]), default=at)
        kept.append("".join(lines[at : at + length]))
        at += length
    return f"{LEFT_OUT}\n".join(kept) if len(kept) > 1 else output


def _likeness(part, lines):
    return SequenceMatcher(None, part, "".join(lines), autojunk=False).ratio()


def run(command):
    """Return what a command writes: the program's in this process, the others' by the system."""
    said = ""
    for part in command.split(" | "):
        words = shlex.split(part)
        said = _program(words[1:], said) if words[0] == "scara-iso" else _system(words)
    return _tidy(said)


def _system(words):
    words = [sys.executable, *words[1:]] if words[0] == "python" else words
    if words[-1] == "&":
        BEHIND.append(subprocess.Popen(words[:-1], stdout=subprocess.DEVNULL))
        return ""
    return subprocess.run(words, capture_output=True, check=True, encoding="utf-8").stdout


def _program(words, typed):
    screen = Screen() if words[0] == "record" and "--json" not in words else io.StringIO()
    with (
        mock.patch("scara_iso.recorder.list_devices", return_value=CABLES),
        mock.patch("sys.stdin", io.TextIOWrapper(io.BytesIO(typed.encode()))),
        contextlib.redirect_stdout(screen),
        contextlib.redirect_stderr(screen),
    ):
        main(words)
    return screen.picture() if isinstance(screen, Screen) else screen.getvalue()


def _tidy(text):
    lines = [line.rstrip() for line in text.strip("\n").splitlines()]
    return "".join(f"{line}\n" for line in lines)


def write(path):
    """Put today's outputs into a page."""
    page = path.read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as folder:
        shutil.copytree(ROOT / "examples", Path(folder) / "examples")
        with contextlib.chdir(folder):
            path.write_text(played(page), encoding="utf-8")


if __name__ == "__main__":
    os.environ["COLUMNS"] = WIDTH
    for name in sys.argv[1:]:
        write(Path(name).resolve())
