"""Two levels: the load comes to rest on either flank of the gap.

The side may alternate, always or mostly, stay for some cycles (sticky), or be drawn anew each time;
a two-state Markov chain holds them all.
"""

from scara_iso.effects import Chain, Parameter, TwoStates

_STICKY = (0.1, 0.16, 0.24)
_TURNS = 0.85
"""A side that mostly alternates, which overcorrection would pass for (test_overcorrection)."""
_SHARE_BELOW = (0.3, 0.4, 0.5, 0.6, 0.7)

EFFECT = TwoStates(
    name="contact_side",
    parameters=(
        Parameter("size", "s", "reading", "distance of the two levels"),
        Parameter(
            "switching",
            "q",
            "",
            "probability that the side changes from cycle to cycle; 1: upper level in odd cycles",
            above=0,
            up_to=1,
        ),
    ),
    cause="the load comes to rest on either flank of a gear's gap (backlash)",
    confirm_by="preload the joint, or approach the pose from one side only: one level must remain; "
    "where the sides take turns on purpose, state them in a column approach",
    at_once="approach the pose from one side only, or preload the joint",
    by_flank=True,
    weight=3.3,  # benchmarks/diagnosis.py, table naming
    test_weight=1.2,  # benchmarks/diagnosis.py, table power
    chains=(
        *(Chain(q, q, 1.3 / len(_STICKY)) for q in _STICKY),
        Chain(_TURNS, _TURNS, 0.2),
        *(Chain(1 - below, below, 1 / len(_SHARE_BELOW)) for below in _SHARE_BELOW),
    ),
)
