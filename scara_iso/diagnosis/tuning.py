"""Every level, prior and threshold of the diagnosis, and what chose it.

One table of ``benchmarks/diagnosis.py`` is meant where only a table is named; its figures stand in
benchmarks/results/diagnosis.md, section 8, those of ``benchmarks/gear.py`` in section 5. The
weights of single effects, chosen on the tables *naming* (prior) and *power* (test), stand in their
files.
"""

from __future__ import annotations

SEED = 9283
"""Seed of every permutation and simulation unless another is given."""

HEAVY_TAILS = "heavy_tails"
"""Name of scatter with heavier tails than the level of the tests allows for."""

AS_OFTEN_ODD = 0.04
"""An odd reading is as likely as tails which throw one as far in so large a share of tables."""

STEP = "step"
"""Name of the effect that a recorded column which changes once looks like."""

UNKNOWN = "unknown"
"""Name of the processes that stand for structure outside the catalogue."""

# levels of the tests

LEVEL = 0.05
"""Level at which a first effect is admitted."""

FURTHER_LEVEL = 0.01
"""Level at which a further one is."""

MISFIT_LEVEL = 0.01
"""Level at which what a fit leaves of reversals is more than their uncertainties (gear.py)."""

FLAG_LEVEL = 0.01
"""Level at which a reading is flagged, in Gaussian scatter."""

MOST_EFFECTS = 3

ORDER_SHARE, TWO_LEVELS_SHARE, OUTLIER_SHARE = 0.7, 0.15, 0.25
"""How much of the level each test of readings uses, together 1.1: what trips one marginal test
(skewed scatter the two levels, heavy tails the outlier) hardly ever trips the other, and Gaussian
scatter trips neither (ablation.py, scatter alone)."""

# tests

PERMUTATIONS = 999
ENOUGH = 50
"""So many orders with as large a statistic settle that p is above 0.05, whatever follows."""
ENOUGH_FURTHER = 10
"""The same of FURTHER_LEVEL."""

PERSISTENCE_SHARE = 0.08
"""Weight of states that persist over that of all hypotheses (table *power*, sticky)."""

SIMULATIONS = 4999
"""Simulations of the marginal tests' null: a second gross reading needs a chance of 0.001."""

FIRST_SIMULATIONS, CLEAR = 199, 0.1
"""Where so many simulations give every p-value above CLEAR the rest are not made."""

FEWEST_MOVED = 3
"""A course that moves fewer readings than this is hardly rarer than any other order, and cannot be
told from as many gross readings."""

FEWEST_PERIODS = 2.5
"""Fewer periods are surely no sine: two bumps pass for two of them (ablation.py)."""

FEWEST_ON_A_LEVEL = 4
"""Fewer readings than this are no level of their own."""

GROSS = 3.0
"""Robust standard deviations beyond which the test of order draws a reading in."""

GROSS_SHARE = 0.1
"""Share of the readings, the farthest, that have no part in the scale of an outlier."""

MOST_SKEWED = 2.2
"""Skewness of the most skewed scatter that the null of the marginal tests allows for."""

SWEEP_SIMULATIONS = 499
"""Simulations of scatter about eq. 16, and permutations of what a fit to a sweep leaves."""

# choice of a name

RIVAL = 0.1
"""Share of the best one's probability from which another is its rival: an effect, or a way in
which unknown scatter may grow with a deviation."""

UNSURE = 0.89
"""The most that is stated of a name that no evidence makes sure: not 90 %, from which a name stands
alone."""

WIDEST_SHARE = 0.2  # benchmarks/blind_spots.py
"""Share of the widest direction of several axes in the tests of two levels and of odd readings."""

THREE_SHARE = 0.2  # benchmarks/blind_spots.py
"""Share of three levels and more in the test of levels."""

FINE = 8.0  # benchmarks/blind_spots.py
"""Divisions that the widest direction spreads over at least where it is tested: the lumps of coarse
dials are levels too."""

TURNS_BACK = -0.25
"""Correlation of a random course with itself one cycle later, below which it turns back at each: an
alternation from mid-run on and negative memory are overcorrection to 0.9 and above in 13 of 16
tables else."""

DIAL_FORMS = 3
"""So many of the likeliest forms of each effect are compared as read on the dial."""

GAIN = 15.0
"""Prior variance of a coefficient over that of the scatter: the g-prior's (table *power*)."""

AMPLITUDES = ((1.0, 0.8), (13.0, 0.15), (200.0, 0.05))
"""Factors on the variances beside the scatter, and their prior: most effects are near it, some
dwarf it. One fixed variance alone could not tell such courses apart (Liang et al. 2008, 2.2)."""

KNOWN_FROM = 30
"""A scatter that the user states counts as seen in so many cycles on which nothing acted."""

SPLIT_SCALE = 4.0
"""Half-normal prior of the distance of two levels, in scatters; below 1 they are one level."""

LEAST_ON_DIAL = 0.15
"""Scatter below which no prior reaches, in divisions: what a finer one rounds to says no more
(real readings)."""

MISFIT = 0.05
"""Share of an effect's size by which its course may differ from the catalogue's equation: no
machine follows one to the last digit (real readings)."""

MOST_MISFIT = 0.15
"""Share of its size up to which what a smooth course leaves along courses like its own is misfit
and no further effect (mended.py, strong courses by other equations)."""

HEAVY_SHARE = 0.2
"""Prior share of scatter with heavy tails (t4) beside Gaussian scatter (table *naming*)."""

LEAST_SCATTER = 0.6
"""Scatter about either of two levels, in divisions: that of a finer one would be the dial's."""

TAKES_PART = 3.0
"""Bayes factor from which an axis moves with the others: at 1, one still axis in six does."""

FITS_BETTER = 3.0
"""Bayes factor of another effect on one of several axes, from which no name is sure for them."""

JOINS = 100.0
"""The same of an axis on which a course shows only beside another (test_stated.py)."""

SHOWN = 20.0
"""The same of an axis that needs no unseen error to fall (ablation.py, two effects)."""

FARTHEST_DEG = 15.0
"""Degrees beyond which no direction is named, however wide the uncertainty."""

SCATTER_POWERS = (0.0, 0.5, 1.0)
"""A scatter of reversals that is not known may grow with the deviation by any of these powers
(gear.py, false alarms)."""

PLACE_NAMED, PLACE_RIVAL = 0.6, 0.1
"""Probability from which the place of an effect is named, and that which a joint or a single pose
must not reach beside it. The right joint is less likely than it is right (joints.py)."""

JOINTS_SHARE = 0.75
"""Share of the joints among the directions of the test of all poses (joints.py)."""

PLACES = {"joint": 0.5, "arm": 0.06, "axis": 0.1, "pose": 0.27, "every": 0.05}
"""Prior weight of the kinds of places: one of the joints, the links, an axis everywhere alike, one
pose, anything else."""

# the unknown (table *outside*)

SMOOTH_WEIGHT, SMOOTH_LENGTHS, SMOOTH_VARIANCES = 0.4, (1.5, 3.0, 6.0, 12.0), (0.5, 2.0, 8.0)
SMOOTH_CYCLES = 30
"""The run of which SMOOTH_LENGTHS are lengths in cycles; longer runs have longer ones."""

CHANGING_LENGTHS = ((3.0, 1.0), (1.0, 3.0))
"""Widths at the first and the last cycle."""
SWINGS = (
    (12.0, 3.0, 0.7),
    (10.0, 2.6, 0.7),
    (4.0, 10.0, 0.7),
    (8.0, 8.0, 0.7),
    (5.5, 5.5, 0.7),
    (4.2, 4.2, 2.0),
    (3.0, 3.0, 2.0),
)
"""Periods at the first and the last cycle, and how many a phase is kept for (ablation.py, chirp;
test_off_the_list.py, beat)."""
CHANGING_WEIGHT, CHANGING_VARIANCES = 0.5, (2.0, 8.0, 32.0)

RECURRING, RECURRING_WEIGHT, RECURRING_VARIANCES = (4, 5, 6, 7, 8), 0.01, (2.0, 8.0, 32.0)
"""Cycles after which a course recurs, as a tooth or an index comes round; with more weight a sine
of so many cycles is no longer sure (test_off_the_list.py). Of 2 and 3 it is the sides or a sine."""

SHARED = 0.5
"""Prior weight of a course without a fixed form that the axes of several poses share, over that
of one for each (ablation.py, five poses)."""

LEVELS_JUMPS, LEVELS_WEIGHT = 3, 0.4
"""A course that stays on one level after another has so many jumps (undeclared.py, three_loads)."""

# what a dial shows

NEIGHBOURS = 2.5
"""Readings within fewer divisions than this are neighbours on the dial: no proof of two levels."""

TWO_DIVISIONS = 1.5
"""Readings within fewer divisions than this are one division and its neighbour."""

MUCH_ROUNDING = 0.2
"""Share of the variance from which rounding is worth a line."""

SAME_SCATTER = 1.6
"""Factor between a stated scatter and the remaining one that thirty readings can account for."""

FEWEST_CYCLES, MOST_CYCLES = 8, 500

# error on unseen cycles (table *held*)

FOLDS = 10

LIKELY = 0.02
"""A fold chooses among the effects that were likelier than this in the whole run."""

# a planned test

POWER = 0.8
"""Share of runs in which the smallest effect that is named would be found."""

ALIKE = 0.9
"""Cosine of two centred courses from which no number of readings tells them apart."""

# a recording that goes on

PAUSE = 20
"""A pause is as long as so many cycles: ten minutes where one takes half a minute."""

PAIR_WEIGHT = 0.1
"""How much rarer two effects at once are than one: with 0.25 damped and trapezoid courses of no
name pass for two."""
PAIR_EFFECTS, PAIR_FORMS = 6, 2
"""Effects, and forms of each, that are tried as the stronger of two."""

RUNS_DIFFER = 0.25
"""Standard deviation, in the logarithm, of the scatter between runs of one machine: RP of the next
run then lies in its interval as often as stated (benchmarks/study, null pairs)."""
