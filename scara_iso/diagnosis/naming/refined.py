"""Periods, time constants and widths between those of the catalogue's grid."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from scara_iso.diagnosis.likelihood.evidence import joint_evidence, log_bayes
from scara_iso.diagnosis.likelihood.hypotheses import Hypothesis
from scara_iso.diagnosis.likelihood.hypothesis_set import build
from scara_iso.diagnosis.likelihood.rounded import DialCourse, course_beside
from scara_iso.diagnosis.problem import Remainder, SearchProblem
from scara_iso.effects import Form, Shape


def refined(problem: SearchProblem, name: str, form: Form, left: Remainder) -> Form:
    """Return the likeliest of the forms near ``form``, where its effect knows nearer ones."""
    near = _near(problem, name, form)
    if not near:
        return form
    hypotheses = build([Hypothesis(name, one, 1.0) for one in near], left.rows, left.basis)
    if left.views.poses is not None:
        log_bf = log_bayes(hypotheses, left.views.columns)
        likely = joint_evidence(log_bf[:, :, np.newaxis], left.views)[:, 0]
    else:
        log_bf = log_bayes(hypotheses, left.views.columns[:, : left.views.axes])
        likely = log_bf.sum(axis=1)
    return hypotheses.members[int(np.argmax(likely))].form


def refined_courses(
    problem: SearchProblem, left: Remainder, forms: Mapping[str, Form]
) -> list[tuple[str, DialCourse]]:
    """Return the courses of those ``forms``, by effect, that have likelier ones near them.

    The name is of a refined form, so its rivals are too.
    """
    found = []
    for name, form in forms.items():
        finer = refined(problem, name, form, left)
        if finer is not form and isinstance(finer, Shape):
            searched = sum(not isinstance(value, str) for value in finer.parameters.values())
            found.append((name, course_beside(left.basis, finer.columns[left.rows], searched)))
    return found


def refined_members(
    problem: SearchProblem, forms: Mapping[str, Form], members: Sequence[Hypothesis]
) -> list[Hypothesis]:
    """Return the forms near the likeliest ones ``forms`` of the effects, which share their weight.

    Readings far beyond their scatter leave much of a course that lies between those of the grid.
    """
    weight = {id(member.form): member.weight for member in members}
    return [
        Hypothesis(name, one, weight.get(id(form), 0.0) / len(near))
        for name, form in forms.items()
        if (near := _near(problem, name, form))
        for one in near
    ]


def _near(problem: SearchProblem, name: str, form: Form) -> tuple[Form, ...]:
    if name not in problem.effects or not isinstance(form, Shape):
        return ()
    return problem.effects[name].near(problem.residual.conditions, form.parameters)
