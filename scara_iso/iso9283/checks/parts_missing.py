"""Parts of the test are not recorded.

test.toml states the poses, velocities and loads. The figures are those of the parts recorded so
far; `test status` shows what is missing, and `record` of the folder records it.
"""

from scara_iso.iso9283.core.results import Finding, Findings, Measured

CODE = "parts-missing"
BRIEF = "parts not recorded"
_RULE = "the test's own plan: every pose is visited under every condition"
_OTHER_TESTS = "the test's own plan: the tests beside the poses"


def check(measured: Measured) -> Findings:
    """Yield a warning that lists the poses that lack, and one of the other tests."""
    for key, others in (("parts_missing", False), ("other_tests_missing", True)):
        if missing := measured.run.metadata.get(key, "").strip():
            yield not_recorded(missing, other_tests=others)


def not_recorded(missing: str, *, other_tests: bool = False) -> Finding:
    """Return the warning that names the parts that lack."""
    rule = _OTHER_TESTS if other_tests else _RULE
    return Finding(CODE, "warning", f"not recorded: {missing}", rule=rule)
