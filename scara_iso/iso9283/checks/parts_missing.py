"""Parts of the test are not recorded.

test.toml states the poses, velocities and loads. The figures are those of the parts recorded so
far; `test status` shows what is missing, and `record` of the folder records it.
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
