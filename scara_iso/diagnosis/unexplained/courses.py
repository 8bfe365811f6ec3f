"""What structure looks like that no effect of the catalogue explains."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from scara_iso.diagnosis.fit import Fit
from scara_iso.diagnosis.residual import Residual
from scara_iso.diagnosis.result import UnexplainedCourse
from scara_iso.diagnosis.tuning import LEVEL
from scara_iso.diagnosis.unexplained.course_formula import formula_for
from scara_iso.diagnosis.unexplained.course_words import in_words, levels_in_words
from scara_iso.effects import Form, Shape


def courses_of(
    residual: Residual, fitted: Fit, form: Form | None, rng: np.random.Generator
) -> Iterator[UnexplainedCourse]:
    """Yield the course of what ``fitted`` leaves in each axis that has one; one level for all.

    ``form`` is the likeliest one of no name: where it is of several levels, these are said.
    """
    left = residual.values - fitted.predicted
    cycle = residual.conditions.cycle
    for name, y in zip(residual.axes, left.T, strict=True):
        if not np.ptp(y):
            continue
        levels = form.columns if isinstance(form, Shape) else np.empty((len(y), 0))
        words = levels_in_words(y, levels, cycle) or in_words(y, cycle)
        found = formula_for(y, cycle, rng, level=LEVEL / len(residual.axes))
        if found is not None:
            errors = {"without": found.alone_rms, "with_formula": found.held_out_rms}
            yield UnexplainedCourse(name, words, found.text, errors, found.p_value)
        elif words:
            yield UnexplainedCourse(name, words, None, {}, None)
