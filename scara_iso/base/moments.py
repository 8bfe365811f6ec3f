"""Dates and times of day as people write them, where day and month cannot be each other's."""

import re

_YEAR_FIRST = re.compile(r"([0-9]{4})[-/.]([0-9]{1,2})[-/.]([0-9]{1,2})(?![0-9])")
_YEAR_LAST = re.compile(
    r"([0-9]{1,2})([-/.]|[-. ]{1,2}(?=[a-zä]))([0-9]{1,2}|[a-zä]{3})[-/. ]{1,2}"
    r"([0-9]{4}|(?<=\.)[0-9]{2})(?![0-9])",
    re.IGNORECASE,
)
_CLOCK = re.compile(
    r",?[ T]*[0-9]{1,2}:[0-9]{2}(?::[0-9]{2}(?:[.,][0-9]{1,9})?)?"
    r"(?:Z| ?[ap]\.?m\.?|[+-][0-9:]{2,5})?",
    re.IGNORECASE,
)
_NAMES = "jan feb mar apr may jun jul aug sep oct nov dec   mär  mai     okt  dez"
_MONTHS = {n: str(k % 12 + 1) for k, n in enumerate(_NAMES.split(" ")) if n}
_LAST_MONTH = 12


def _date_at_start(text: str) -> re.Match[str] | None:
    return _YEAR_FIRST.match(text) or _YEAR_LAST.match(text)


def is_date(text: str) -> bool:
    """Say whether a text has the form of a date, and no time behind it."""
    found = _date_at_start(text)
    return found is not None and found.end() == len(text)


def is_moment(text: str) -> bool:
    """Say whether a text has the form of a date, a time of day, or both."""
    found = _date_at_start(text)
    behind = text[found.end() :] if found else text
    return is_date(text) or _CLOCK.fullmatch(behind) is not None


def in_iso(text: str) -> str:
    """Return a date, with its time, as ISO 8601 spells it: of ``15.2.2026``, ``15/02/2026 9:30``.

    ``05/02/2026`` is left as it is: either may be the month, where 15 is none.
    """
    found = _date_at_start(text)
    if found is None:
        return text
    year, month, day = found.groups() if found.re is _YEAR_FIRST else found.group(4, 3, 1)
    if found.re is _YEAR_LAST and month.isdigit() and found[2] != ".":
        if int(month) > _LAST_MONTH:
            month, day = day, month
        elif int(day) <= _LAST_MONTH and int(day) != int(month):
            return text
    month = _MONTHS.get(month.lower(), month)
    time = re.sub(r"^,?[ T]+([0-9]{1,2}:)", lambda t: f"T{t[1]:0>3}", text[found.end() :])
    return f"20{year}"[-4:] + f"-{month:0>2}-{day:0>2}{time}"
