"""What structure looks like that no effect of the catalogue explains."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from scara_iso.diagnosis.fit import Fit
from scara_iso.diagnosis.residual import Residual
from scara_iso.diagnosis.result import UnexplainedCourse
from scara_iso.diagnosis.tuning import LEVEL, UNKNOWN
from scara_iso.diagnosis.unexplained.course_formula import formula_for
from scara_iso.diagnosis.unexplained.course_words import in_words, levels_in_words
from scara_iso.effects import Form, Shape


def courses_of(
    residual: Residual, fitted: Fit, form: Form | None, rng: np.random.Generator
) -> Iterator[UnexplainedCourse]:
    """Yield the course of each axis that has a learned one; one level for the formulas of all.

    Words are of the whole course, the effects found included: that is what the readings do. A
    formula is of what the effects leave. ``form`` is the likeliest one without a name: where it is
    of several levels, these are described.
    """
    cycle = residual.conditions.cycle
    learned = [term for term in fitted.terms if term.effect == UNKNOWN]
    named = [p for t, p in zip(fitted.terms, fitted.parts, strict=True) if t.effect != UNKNOWN]
    left = residual.values - sum(named, np.zeros_like(residual.values))
    levels = form.columns if isinstance(form, Shape) else np.empty((len(cycle), 0))
    for a in (int(np.flatnonzero(term.moves)[0]) for term in learned):
        y = left[:, a] - left[:, a].mean()
        words = levels_in_words(y, levels, cycle) or in_words(fitted.predicted[:, a], cycle)
        found = formula_for(y, cycle, rng, level=LEVEL / len(residual.axes))
        if found is None:
            yield UnexplainedCourse(residual.axes[a], words, None, {}, None)
        else:
            errors = {"without": found.alone_rms, "with_formula": found.held_out_rms}
            yield UnexplainedCourse(residual.axes[a], words, found.text, errors, found.p_value)
