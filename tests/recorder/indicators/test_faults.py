"""What an instrument says is wrong, by its code, and the modem lines that its cable needs."""

import pytest

from scara_iso.recorder.indicators import (
    InstrumentFault,
    Reading,
    find_dialect,
    find_dialects,
)

FAULTS = [
    ("mitutoyo-mux", b"911", "911", "no data", "1"),
    ("mitutoyo-mux", b"992", "992", "format error", "9"),
    ("mitutoyo-mux", b"939", "939", "system error", "3"),
    ("mitutoyo-mux", b"918", "918", "unknown fault", "1"),
    ("keyence-dlrs1a", b"ER,SR,00", "ER 00", "invalid command", None),
    ("keyence-dlrs1a", b"ER,SR,20", "ER 20", "wrong length", None),
    ("keyence-dlrs1a", b"ER,SR,21", "ER 21", "wrong number of parameters", None),
    ("keyence-dlrs1a", b"ER,SR,22", "ER 22", "wrong parameter", None),
    ("keyence-dlrs1a", b"ER,SR,29", "ER 29", "communication error", None),
    ("keyence-dlrs1a", b"ER,SR,65", "ER 65", "no such unit", None),
    ("keyence-dlrs1a", b"ER,SR,77", "ER 77", "unknown error", None),
    ("opto-rs232", b"ERR0", "ERR0", "sensor error (speed, scale)", None),
    ("opto-rs232", b"ERR1", "ERR1", "command not understood", None),
    ("opto-rs232", b"err2", "err2", "parity error: check the port's settings", None),
    ("opto-rs232", b"ERR3", "ERR3", "measuring range exceeded", None),
    ("opto-rs232", b"ERR12", "ERR12", "unknown error", None),
    ("opto-rs232", b"OV", "OV", "outside the range", None),
    ("cdi-starrett-iq", b"OUT OF BOUNDS", "OUT OF BOUNDS",
     "the gauge refused a command", None),
]  # fmt: skip


@pytest.mark.parametrize(("key", "line", "code", "message", "channel"), FAULTS)
def test_a_fault_says_its_code_its_meaning_and_its_channel(key, line, code, message, channel):
    (fault,) = find_dialect(key).parse(line)
    assert isinstance(fault, InstrumentFault)
    assert (fault.code, fault.message, fault.channel) == (code, message, channel)


@pytest.mark.parametrize(("key", "line"), [(key, line) for key, line, *_ in FAULTS])
def test_a_fault_with_a_byte_more_or_less_is_no_reading(key, line):
    for damaged in (line[:-1], line[1:], line + b"0", b"0" + line):
        events = find_dialect(key).parse(damaged)
        assert not any(isinstance(event, Reading) for event in events)


def test_only_the_opto_cables_and_one_multiplexer_are_fed_by_modem_lines():
    lines = {key: (d.line.dtr, d.line.rts) for key, d in find_dialects().items()}
    fed = {key: pair for key, pair in lines.items() if pair != (None, None)}
    assert fed == {
        "mux24": (True, None),
        "opto-rs232": (True, False),
        "opto-rs232-simplex": (True, True),
        "opto-rs232-tesa": (True, False),
        "opto-rs232-trimos": (True, False),
        "opto-rs232-ibr": (True, False),
    }
