"""A characteristic was planned, and these readings do not give it.

test.toml lists the characteristics of the test. For one that the readings do not give, the message
states what it needs: record that, or take it off the list.
"""

from scara_iso.iso9283.characteristics import needs
from scara_iso.iso9283.core.results import Finding, Findings, Measured

CODE = "not-measured"
_RULE = "the test's own plan: every characteristic that it lists is measured"


def check(measured: Measured) -> Findings:
    """Yield a warning for each characteristic that is planned and not given."""
    planned = measured.run.metadata.get("characteristics", "").split(",")
    for code in (one.strip() for one in planned):
        if code and code not in measured.codes:
            why = f"needs {needs()[code]}" if code in needs() else "no characteristic of this name"
            yield Finding(CODE, "warning", f"{code} is planned and not measured: {why}", rule=_RULE)
