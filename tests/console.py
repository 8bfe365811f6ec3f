"""Play the console blocks of a page: each command in order, in one folder, beside examples/.

``python tests/console.py docs/tutorial.md`` writes the outputs of today's program into the page;
a line ``...`` in an output stands for lines that are left out, and such a block is kept.
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
from pathlib import Path
from unittest import mock

from scara_iso.cli import main
from scara_iso.ports import Device

ROOT = Path(__file__).parents[1]
BLOCK = re.compile(r"(?<=^```console\n).*?(?=^```)", re.MULTILINE | re.DOTALL)
WIDTH = "80"
LEFT_OUT = "..."
CABLES = (
    Device("/dev/ttyS0", "ttyS0", None, None, None),
    Device("/dev/ttyUSB0", "USB-Serial Controller", "067b:2303", None, "1-2"),
)
"""The serial ports of the machine that the pages show."""


class Screen(io.StringIO):
    """A terminal of which the last picture counts."""

    def isatty(self):
        return True

    def picture(self):
        last = self.getvalue().rpartition("\x1b[2K")[2]
        return re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", last)


def played(page):
    """Return the page as its commands make it today; COLUMNS and the folder are the caller's."""
    return BLOCK.sub(lambda block: _played_block(block[0]), page)


def _played_block(block):
    parts = re.split(r"^(\$ .*\n)", block, flags=re.MULTILINE)
    assert not parts[0], f"a console block begins with a command: {parts[0]!r}"
    said = []
    for line, shown in zip(parts[1::2], parts[2::2], strict=True):
        output = run(line[2:].strip())
        said += [line, shown if alike(shown, output) else output]
    return "".join(said)


def alike(shown, output):
    """Say whether an output is the one shown, with or without the lines left out."""
    kept = [re.escape(part) for part in re.split(rf"^{re.escape(LEFT_OUT)}\n", shown, flags=re.M)]
    return re.fullmatch("(?:.*\n)*?".join(kept), output) is not None


def run(command):
    """Return what a command writes: the program's in this process, the others' by the system."""
    said = ""
    for part in command.split(" | "):
        words = shlex.split(part)
        said = _program(words[1:], said) if words[0] == "scara-iso" else _system(words)
    return _tidy(said)


def _system(words):
    return subprocess.run(words, capture_output=True, check=True, encoding="utf-8").stdout


def _program(words, typed):
    screen = Screen() if words[0] == "record" and "--json" not in words else io.StringIO()
    with (
        mock.patch("scara_iso.ports.list_devices", return_value=CABLES),
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
