"""Columns and readings that may be something else than they are taken for: each is asked about.

A heading may say that readings are not what they seem: a zero beside them, a side, which of them
are valid. Numbers may: a count of rows, a column made of the readings, coordinates of poses.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations

import numpy as np

from scara_iso.run import CONDITIONS, FEW_LEVELS, FloatArray, IntArray, Run, declared_conditions
from scara_iso.tables.columns import RARE, TWO, Columns
from scara_iso.tables.grid import NAME_CONDITION, OF_COLUMNS
from scara_iso.tables.vocabulary.names import (
    COLUMNS,
    COVARIATES,
    Column,
    Kind,
    is_axis,
    pose_and_name,
)
from scara_iso.tables.vocabulary.sentences import affirms, says_nothing, strikes_its_row
from scara_iso.tables.vocabulary.words import (
    WORDS,
    Subject,
    clean,
    is_of_another,
    names_an_instrument,
    numbers_a_thing,
    plain_heading,
    quoted,
    subject_of_heading,
    topic_of,
)

_FEWEST, _MOST = 10, 500
"""Rows from which 1, 2, 3 .. is a count and no chance, and to which a column is compared."""
_DIRECTION = "direction|richtung"
_SIGNS = (-1, 0, 1)
_AXIS_FIRST = r"(?i)\W*(x|y|z|theta)(?![^\W\d_])"
_AXIS_LAST = r"(?i).*[\W_](x|y|z|theta)(?:[\W_]+(?:mm|[uµμ]m|in|inch|deg))?\W*"
_FEWEST_MARKED, _MARKS = 15, 10
"""Rows: of fewer a one among zeros is no mark; nor is a number of two digits."""
_FEW = 3
"""Rows that each level has."""
_FEWEST_MADE, _MOST_MADE = 8, 10_000
_LACKS_FIRST = 2
"""Where a count begins whose first cycle was removed."""
_WITH_GAPS = 1.5
"""Numbers of rows reach so many times as far as there are rows."""
_COMPUTED, _SAME_SIZE = 0.998, 0.03
"""Correlation and size that rounding leaves to a figure of the readings beside it."""


Colours = Mapping[int, frozenset[str]]


def check_columns(columns: Columns, stated: Mapping[str, str], colours: Colours) -> list[str]:
    """Add what columns may be instead; return what is a warning."""
    _check_axis_columns(columns)
    _check_headings(columns, stated)
    return _of_other_colours(colours, columns) if colours else []


def check_readings(run: Run, columns: Columns) -> list[str]:
    """Add what of a run may be no reading, cycle or condition; return what is a warning alone."""
    _check_followed(run, columns)
    _check_made_columns(run, columns)
    layout, instruments = columns.layout, WORDS["axis"]["instrument"]
    if (word := layout.worded) and word not in instruments and not names_an_instrument(word):
        return [f"{columns.faults.place(layout.header_line)} {quoted(word)} with each axis"]
    return []


def _of_other_colours(colours: Colours, columns: Columns) -> list[str]:
    """Return a warning of each row but the first that is coloured unlike most: it may not count."""
    own = {line: colours.get(line, frozenset()) for line in columns.all_lines().tolist()[1:]}
    usual = next((seen for seen, _ in Counter(own.values()).most_common(1)), None)
    found = [line for line, seen in own.items() if seen != usual]
    few = found if len(found) <= RARE * len(own) else []
    return [f"{columns.faults.place(line)}, coloured unlike the others" for line in few]


def _check_headings(columns: Columns, stated: Mapping[str, str]) -> None:
    """Add each column whose heading changes what readings are, and is not understood."""
    conditions, layout = declared_conditions(stated), columns.layout
    for column in layout.of(Kind.COVARIATE, Kind.COMMENT):
        heading = clean(column.heading)
        if heading.lower() in conditions or column.name in COVARIATES:
            continue
        subject, what = subject_of_heading(heading), ""
        if subject is not None and _changes(subject, heading, column, columns):
            what = f"speaks of {subject.value}, which changes readings"
        elif subject is None and _marks_rows(column, columns):
            marks = np.unique(columns.values(column))
            what = f"is {marks[0]:g} or {marks[1]:g}, one of them rarely"
            subject, what = Subject.EXCLUDED, f"{what}: do all rows count?"
        if subject is not None and what:
            remedy = OF_COLUMNS[subject].format(heading)
            columns.fault(column, f"{column.called} {what}", remedy=remedy)


def declared_in_words(
    columns: Columns, stated: Mapping[str, str]
) -> tuple[list[Column], dict[str, FloatArray]]:
    """Return the columns of a few words that the head declares to be conditions of the test.

    Beside them is a covariate for each word of one but the first: 1 in its rows, else 0.
    """
    names = declared_conditions(stated)
    heading = {c: clean(c.heading) for c in columns.layout.of(Kind.COMMENT)}
    words = {c: columns.distinct(c) for c, name in heading.items() if name.lower() in names}
    few = {c: found for c, found in words.items() if 1 < len(found) <= FEW_LEVELS}
    coded_words = {
        f"{heading[c]} {word or 'blank'}": (columns.labels(c) == word).astype(np.float64)
        for c, found in few.items()
        for word in found[1:]
    }
    return [*few], coded_words


def _changes(subject: Subject, heading: str, column: Column, columns: Columns) -> bool:
    values, counts = np.unique(columns.values(column), return_counts=True)
    if subject is Subject.EXCLUDED:
        words = columns.distinct(column) if column.kind is Kind.COMMENT else None
        return _excludes(heading, words or [f"{x:g}" for x in values.tolist()], counts)
    if column.kind is not Kind.COVARIATE:
        return False
    if subject is Subject.SIDE:
        return 1 < len(values) and bool(_FEW * len(values) <= counts.sum())
    if topic_of(heading) is None:
        return len(values) > 1
    return bool(np.any(values != (1 if subject is Subject.SCALE else 0)))


def _marks_rows(column: Column, columns: Columns) -> bool:
    """Say whether a column of two small numbers, one of them rare, may say which rows count."""
    values = columns.values(column) if column.kind is Kind.COVARIATE else np.zeros(1)
    marks, counts = np.unique(values, return_counts=True)
    few = len(values) >= _FEWEST_MARKED and counts.min() <= RARE * len(values)
    return bool(few and len(marks) == TWO and np.isin(marks, range(_MARKS)).all())


def _excludes(heading: str, cells: Sequence[str], counts: IntArray) -> bool:
    """Say whether a column of these ``cells``, so often each, says that some row does not count."""
    if topic_of(plain_heading(heading)) is None:
        return len(cells) == TWO and bool(counts.min() <= RARE * counts.sum())
    alike = len(cells) == 1 < counts.sum() and not affirms(plain_heading(heading))
    if alike and topic_of(heading) is None:
        return strikes_its_row(cells[0])  # as a status does
    return len(cells) > 1 or any(map(says_nothing, cells)) is affirms(plain_heading(heading))


def check_header(columns: Columns) -> None:
    """Add what columns are too many, of one name, or formulas, and axes of a pose beside others."""
    layout, first = columns.layout, dict[tuple[Kind, str], Column]()
    if layout.width > COLUMNS:
        what = f"{layout.width} columns, more than {COLUMNS}"
        remedy = "leave the columns of the readings only"
        columns.faults.add(what, layout.header_line, remedy=remedy)
    for column in layout.of(Kind.COVARIATE):
        _check_covariate(column, columns)
    for column in layout.columns:
        if column.kind in (Kind.NAMELESS, Kind.COMMENT):
            continue
        if column.heading.startswith(("=", "@")):
            columns.fault(column, "a formula for a column's name", remedy="write the name itself")
        covariate = column.kind in (Kind.TIMESTAMP, Kind.DIRECTION)
        kind = Kind.COVARIATE if covariate else column.kind
        name = "time_s" if column.kind is Kind.TIMESTAMP else column.name
        before = first.setdefault((kind, name.lower()), column)
        if before is not column:
            columns.fault(
                column,
                f"two columns for {name}: fields {before.position + 1} and {column.position + 1}",
                remedy="leave one column for each axis and quantity; a block beside the first goes "
                "below it, and of several poses the columns are headed P1_X, P2_X",
            )


def _check_covariate(column: Column, columns: Columns) -> None:
    """Add a covariate that names an axis of a pose, and one of two units.

    The readings of the first would be lost; of the second the unit row says another than the name.
    """
    heading = column.heading
    found = pose_and_name(heading)
    if found and is_axis(found[1]):
        what = f"{quoted(heading)} is of pose {found[0]}, other axes of none"
        remedy = (
            "head each axis with its pose, as P1_X and P2_X; call a column of no readings comment"
        )
        columns.fault(column, what, remedy=remedy)
    unit, _, below = column.unit.partition(" over ")
    if below:
        what = f"{quoted(heading)} is in {unit}, the unit row says {below}"
        remedy = "let the heading and the unit row state the same unit"
        columns.fault(column, what, remedy=remedy)


def _check_axis_columns(columns: Columns) -> None:
    """Add each axis that counts rows, says directions, or stands beside a dial of no axis."""
    layout, axes = columns.layout, columns.layout.of(Kind.AXIS)
    for column in axes:
        heading, values = column.heading, columns.values(column)
        in_turn = values[:1] + np.arange(len(values))
        counts = len(values) >= _FEWEST and values[0] in (0, 1) and np.all(values == in_turn)
        if len(axes) > 1 and not layout.of(Kind.CYCLE) and counts:
            what = f"column {column.name} counts the rows: it looks like the cycle number"
            remedy = "rename it to cycle; if these are readings, add a column cycle"
            columns.fault(column, what, remedy=remedy)
        if re.search(_DIRECTION, heading.lower()) and np.isin(values, _SIGNS).all():
            what = f"{quoted(heading)} holds +1, 0 and -1 only: directions, not readings"
            remedy = (
                f"call it approach where it says from which side; {column.name} "
                "where these are readings"
            )
            columns.fault(column, what, remedy=remedy)
    for column in layout.of(Kind.COVARIATE):
        values = columns.values(column)  # whole ones may be the numbers of dials
        axis = None if column.condition or _rises(values) else _axis_of(column.heading)
        if axis and axis not in {named.name for named in axes}:
            where = "begins" if re.match(_AXIS_FIRST, clean(column.heading)) else "ends"
            columns.fault(
                column,
                f"{column.called} {where} as the axis {axis}, which is not there",
                remedy=f"call it {axis} with its unit if these are its readings, else by a name "
                "that does not begin so; or remove it",
            )
        varies = len(set(values.tolist())) > 1 and bool(np.any(values != np.round(values)))
        if varies and names_an_instrument(column.heading):
            columns.fault(
                column,
                f"{column.called} holds readings of no axis: are "
                f"{' and '.join(axis.name for axis in axes)} the poses' coordinates?",
                remedy="call it by its axis, as X, and coordinates command_X, with a column pose; "
                "call a column of no readings comment",
            )


def _axis_of(heading: str) -> str | None:
    words = clean(heading)
    named = re.match(_AXIS_FIRST, words)
    if named is None and not is_of_another(words):
        named = re.fullmatch(_AXIS_LAST, words)
    if named is None:
        return None
    return "theta" if len(named[1]) > 1 else named[1].upper()


def _rises(values: FloatArray) -> bool:
    return bool(np.all(np.diff(values) > 0))


def _unknown(run: Run, columns: Columns) -> Iterator[tuple[str, FloatArray]]:
    known = {c.name for c in columns.layout.of(Kind.COVARIATE) if c.condition} | CONDITIONS
    declared = declared_conditions(run.metadata)
    for name, values in run.covariates.items():
        if name not in known and name.lower() not in declared:
            yield name, values


def _check_followed(run: Run, columns: Columns) -> None:
    """Add each covariate of no known meaning that numbers robots or dials, or is in the readings.

    Readings of several robots are never taken together. In the readings is a column that they
    follow one to one: half of their scatter or more is gone with it, and so much as is by chance
    in less than one column of 100,000, as with a zero that is still in them.
    """
    layout, faults = columns.layout, columns.faults
    for name, values in _unknown(run, columns) if len(run) <= _MOST else ():
        if _rises(values):
            continue
        whole = set(values.tolist()) if bool(np.all(values == np.round(values))) else set()
        if len(whole) > 1 and numbers_a_thing(name):
            faults.add(
                f"column {quoted(name)} holds {len(whole)} numbers: readings of several robots or "
                "dials?",
                layout.header_line,
                remedy="save those of each as a table of its own" + NAME_CONDITION.format(name),
            )
        if is_of_another(name):
            continue
        for axis in layout.of(Kind.AXIS):
            readings = columns.values(axis)
            if any(_follow(readings[rows], values[rows]) for _, rows in run.rows_by_pose()):
                own = _axis_of(name) == axis.name
                what = f"{axis.name} follows column {quoted(name)} one to one: "
                faults.add(
                    what + ("which of them are the readings?" if own else "is it a zero?"),
                    layout.header_line,
                    remedy=f"leave one column of readings of {axis.name}"
                    if own
                    else OF_COLUMNS[Subject.ZERO] + NAME_CONDITION.format(name),
                )


def _follow(readings: FloatArray, values: FloatArray) -> bool:
    if len(readings) < _FEWEST:
        return False
    left = min(0.5, 1e-5 ** (2 / (len(readings) - 2)))
    return bool(np.var(readings - values) < left * np.var(readings))


def _check_made_columns(run: Run, columns: Columns) -> None:
    """Add each covariate that numbers the rows in another order, or is computed of the readings.

    As a condition the one would hide the true order of the cycles, the other explain the readings
    by themselves.
    """
    for name, values in _unknown(run, columns) if _FEWEST_MADE <= len(run) <= _MOST_MADE else ():
        what, remedy = "", "call it cycle"
        if not columns.layout.of(Kind.CYCLE) and _numbers_rows(run, values):
            what = "numbers the rows, and they do not follow each other from 1 on"
        elif figure := next(_figures_in(run, values), ""):
            what, remedy = f"is {figure} of the readings beside it", "remove the column"
        if what:
            remedy += NAME_CONDITION.format(name)
            what = f"column {quoted(name)} {what}"
            columns.faults.add(what, columns.layout.header_line, remedy=remedy)


def _numbers_rows(run: Run, values: FloatArray) -> bool:
    """Say whether whole numbers from 0, 1 or 2 on stand once each, from 2 or not in order."""
    parts = [values[rows] for _, rows in run.rows_by_pose()]
    whole = np.array_equal(values, np.round(values))
    once = whole and all(len(np.unique(part)) == len(part) >= _FEWEST_MADE for part in parts)
    if not once or any(part.min() not in (0, 1, 2) for part in parts):
        return False
    near = all(np.ptp(part) <= _WITH_GAPS * len(part) for part in parts)
    from_2 = all(part[0] == _LACKS_FIRST for part in parts)
    return near and (from_2 or not all(np.all(np.diff(part) == 1) for part in parts))


def _figures_in(run: Run, values: FloatArray) -> Iterator[str]:
    """Yield which figure of the readings of each row a column holds, in any unit of length."""
    readings = np.stack([axis.shown for axis in run.axes.values()])
    count, middle = len(readings), readings.mean(axis=0)
    figures = [
        ("the mean", middle),
        ("the sum", readings.sum(axis=0)),
        ("the range", np.ptp(readings, axis=0)),
        ("the distance", np.linalg.norm(readings, axis=0)),
        ("the distance from the mean", np.linalg.norm((readings.T - readings.mean(1)).T, axis=0)),
        ("the scatter", readings.std(axis=0)),
        ("the scatter", readings.std(axis=0) * np.sqrt(count / max(count - 1, 1))),
    ]
    pairs = combinations(run.axes, 2)
    figures += [
        (f"the difference of {a} and {b}", run.axes[a].shown - run.axes[b].shown) for a, b in pairs
    ]
    for name, figure in figures if count > 1 and np.ptp(values) > 0 else ():
        if np.ptp(figure) > 0 and abs(np.corrcoef(figure, values)[0, 1]) > _COMPUTED:
            size = float(np.std(values) / np.std(figure))
            if any(abs(size / unit - 1) < _SAME_SIZE for unit in (1e-3, 1.0, 1e3)):
                yield name
