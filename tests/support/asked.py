"""What a case asks, through the public command line alone."""

import contextlib
import io
import json
import re
from dataclasses import dataclass

import numpy as np
import pytest

from scara_iso.commands import main

REFUSED = (2, 65, 73)
CRASHED = 70

_THOUSANDTHS = (
    502, 498, 500, 503, 499, 501, 497, 500, 502, 499, 500, 504, 498, 501, 500, 496,
    501, 499, 503, 500, 498, 502, 501, 499, 500, 497, 502, 500, 501, 503, 499,
)  # fmt: skip
READINGS = [reading / 1000 for reading in _THOUSANDTHS]
CYCLES = range(1, 32)
HEAD = ("# unit: mm", "# resolution: 0.001")


def given(condition):
    """Stop where a case is not what it is meant to be: no failure of what is asked."""
    if not condition:
        raise ValueError("the case does not show what it is made for")


def repeatability(readings):
    """Return RP of one axis by eq. 2-6, computed apart from the program."""
    distances = np.abs(np.asarray(readings) - np.mean(readings))
    return float(distances.mean() + 3 * distances.std(ddof=1))


def table(path, columns, head=HEAD, delimiter=","):
    """Write the lines of a head and the columns, by heading, as a table."""
    rows = [columns, *zip(*columns.values(), strict=True)]
    lines = [*head, *(delimiter.join(map(str, row)) for row in rows)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


@dataclass(frozen=True)
class Answer:
    """What one command gave: exit code, output and messages."""

    code: int
    out: str
    err: str

    @property
    def document(self):
        """The JSON object."""
        assert self.out, self.err
        return json.loads(self.out)

    @property
    def refused(self):
        """Whether nothing was computed, and a message says what to do."""
        return self.code in REFUSED and bool(self.err.strip())

    @property
    def plain(self):
        """All that was said, in one line of small letters."""
        return re.sub(r"\s+", " ", f"{self.out} {self.err}").casefold()


def ask(*argv):
    """Run the command in this process; a defect of the program is no answer."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main([str(word) for word in argv])
    if code == CRASHED:
        raise RuntimeError(err.getvalue())
    return Answer(code, out.getvalue(), err.getvalue())


def names(answer, *words):
    """Say whether one of the words stands in what was said."""
    return any(_word(word, answer.plain) for word in words)


def _word(word, text):
    before, after = (r"(?<!\w)" * word[0].isalnum(), r"(?!\w)" * word[-1].isalnum())
    return re.search(before + re.escape(word.casefold()) + after, text) is not None


def figures(answer):
    """Return RP by axis of the only pose."""
    (pose,) = answer.document["poses"]
    return {name: axis["RP"] for name, axis in pose["axes"].items()}


def heard(path, words, expected, *options):
    """Assert that what a table states was used, or refused in one of the ``words``.

    ``expected`` is the right RP by axis, None where only a refusal is right. What changes a figure
    may not merely be listed as not used.
    """
    answer = ask("analyze", path, "--json", *options)
    if answer.refused:
        assert names(answer, *words), f"refused, but not for what is stated: {answer.err}"
        return
    found = figures(answer)
    used = expected is not None and found == pytest.approx(expected, rel=1e-6)
    assert used, f"passed over in silence: RP {found} where {expected} is right"
