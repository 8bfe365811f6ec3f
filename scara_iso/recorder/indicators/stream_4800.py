"""Low-cost USB cables that send ten bytes every 300 ms: sign, seven digits, point."""

from scara_iso.recorder.indicators._grammar import line_dialect

DIALECT = line_dialect(
    key="stream-4800",
    instruments="INSPEC 711-201B and similar USB cables that send all the time",
    cable="the USB cable of the gauge",
    line="4800 8N1",
    reading=rb"(?P<sign>[+-])(?=[\d.]{8}\Z)(?P<digits>\d+\.\d+)",
    form="{sign}{digits}",
    units={None: ""},
    longest_frame=9,
    digits=7,
    decimals=(3, 1, 2, 4, 5, 6),
    source="INSPEC 711-201B, seller's page",
    confidence="low",
    unverified=(
        "the line end (CR is a guess; CR, LF and both are taken)",
        "what an error looks like",
        "a value may be 0.3 s old when it arrives",
    ),
)
