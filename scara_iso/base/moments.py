"""Dates and times of day as people write them, where day and month cannot be each other's."""

import re

_DATE = re.compile(
    r"(?i)([0-9]{4})[-/.]([0-9]{1,2})[-/.]([0-9]{1,2})(?![0-9])"
    r"|([0-9]{1,2})([-/.]|[-. ]{1,2}(?=[a-z]))([0-9]{1,2}|[a-z]{3})[-/. ]{1,2}"
    r"([0-9]{4}|(?<=\.)[0-9]{2})(?![0-9])"
)
_CLOCK = re.compile(
    r"(?i),?[ T]*[0-9]{1,2}:[0-9]{2}(:[0-9]{2}([.,][0-9]+)?)?(Z| ?[ap]\.?m\.?|[+-][0-9:]{2,5})?"
)
_TIME_OF_DAY = re.compile(
    r"(?i)([01]?[0-9]|2[0-3]):([0-5][0-9]):([0-5][0-9](?:[.,][0-9]{1,9})?)(?: ?([ap])\.?m\.?)?"
)
_MONTHS = "jan feb mar apr may jun jul aug sep oct nov dec"
_MOST_MONTHS = 12


def is_moment(text: str) -> bool:
    """Say whether a text has the form of a date, a time of day, or both."""
    behind = _DATE.sub("", text, 1)
    return _CLOCK.fullmatch(behind) is not None or (behind == "" != text)


def in_iso(text: str) -> str:
    """Return a date, and its time, in ISO 8601: ``15/02/2026``, not the open ``05/02/2026``."""
    found = _DATE.match(text)
    if found is None:
        return text
    year, month, day = found.group(1, 2, 3) if found[1] else found.group(7, 6, 4)
    if found[5] in ("/", "-") and month.isdigit():
        if max(int(day), int(month)) <= _MOST_MONTHS and int(day) != int(month):
            return text
        month, day = sorted((month, day), key=int)
    month = month if month.isdigit() else str(_MONTHS.find(month.lower()) // 4 + 1)
    time = re.sub(r"^,?[ T]+([0-9]{1,2}:)", lambda t: f"T{t[1]:0>3}", text[found.end() :])
    return f"20{year}"[-4:] + f"-{month:0>2}-{day:0>2}{time}"


def seconds_of_day(text: str) -> float | None:
    """Return the seconds since midnight of a time of day to the second; None for another text."""
    found = _TIME_OF_DAY.fullmatch(text)
    if found is None:
        return None
    hour, minute, second = int(found[1]), int(found[2]), float(found[3].replace(",", "."))
    if found[4]:
        hour = hour % 12 + 12 * (found[4].lower() == "p")
    return hour * 3600 + minute * 60 + second
