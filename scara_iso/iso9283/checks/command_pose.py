"""A command pose is stated, and no accuracy AP can be given.

AP (7.2.1) is the distance from the command pose to the mean: it needs dials whose zero is referred
to the command pose: state ``# dial_zero: command``. A command pose belongs to one pose: with
several, write ``# command_X[P3]: 0.1`` for each, or columns ``command_X``.
"""

from collections.abc import Mapping

from scara_iso.iso9283.core.results import Finding, Findings, Measured

CODE = "command-pose"


def check(measured: Measured) -> Findings:
    """Yield a warning for a command coordinate of no pose, and a note where AP is left out."""
    run = measured.run
    stated = {name: axis.command for name, axis in run.axes.items() if axis.command is not None}
    labels = [pose.label for pose in measured.poses]
    for name, command in stated.items():
        lacking = [str(one or "P1") for one in labels if run.command_of(name, one) is None]
        if not lacking:
            continue
        if len(labels) > 1 and not isinstance(command, Mapping):
            said = f"one command coordinate for {len(labels)} poses belongs to none; not used"
        elif len(lacking) == len(labels):
            said = "a command coordinate is stated for a pose that is not in the table; not used"
        else:
            said = f"no command coordinate is stated for {', '.join(lacking[:10])}"
        advice = f"write '# command_{name}[{lacking[0]}]: ...' for each pose"
        yield Finding(CODE, "warning", said, name, advice=advice)
    if stated and not run.dial_zero_is_command:
        said = "no accuracy AP: the table does not say that the dials' zero is the command pose"
        yield Finding(CODE, "info", said, advice="add '# dial_zero: command' if it is")
