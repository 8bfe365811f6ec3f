"""Parts of the test are not recorded.

The test.toml of a test's folder says which poses are visited at which velocities and loads. What
is given here is made of the parts that are there; `test status` shows what is missing, and
recording into the folder goes on with it.
"""

from scara_iso.iso9283.results import Finding, Findings, Measured

CODE = "parts-missing"
BRIEF = "parts not recorded"
_RULE = "the test's own plan: every pose is visited under every condition"


def check(measured: Measured) -> Findings:
    """Yield a warning that lists the parts that lack."""
    if missing := measured.run.metadata.get("parts_missing", "").strip():
        yield not_recorded(missing)


def not_recorded(missing: str) -> Finding:
    """Return the warning that names the parts that lack."""
    return Finding(CODE, "warning", f"not recorded: {missing}", rule=_RULE)
