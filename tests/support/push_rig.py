"""A joint behind play, a spring and Coulomb friction, pushed by steps: by equations of its own.

The link stands where it stands while |F - k d(x)| <= F_c, d the part of x beyond the play; else it
slides on to where the two are equal, found by bisection. The program's play operator on the force
is not used.
"""

from functools import lru_cache

import numpy as np


def beyond(x, half_play):
    return np.sign(x) * max(abs(x) - half_play, 0.0)


@lru_cache(maxsize=64)
def positions(force, *, stiffness, half_play, friction, start=0.0):
    """Return where the link rests after each force [mm]; stiffness in N/mm."""
    x, found = start, []
    for F in force:
        left = F - stiffness * beyond(x, half_play)
        if abs(left) > friction:
            way = np.sign(left)
            near, far = x, way * (half_play + (abs(F) + friction) / stiffness + 1.0) + x
            for _ in range(80):
                middle = (near + far) / 2
                slides = way * (F - stiffness * beyond(middle, half_play)) > friction
                near, far = (middle, far) if slides else (near, middle)
            x = near
        found.append(x)
    return np.array(found)


def forces(most=100.0, step=10.0, loops=3):
    """Return steps from nothing up, down and back, ``loops`` times, ending at nothing."""
    up = np.arange(-most, most + step / 2, step)
    whole = np.concatenate([up[::-1][1:], up[1:]])
    run_in = np.arange(0, most + step / 2, step)
    return np.concatenate([run_in, *[whole] * loops])


def readings(rng, *, stiffness=500.0, half_play=0.02, friction=6.0, noise=0.0, division=None,
             drift=0.0, **steps):  # fmt: skip
    """Return forces and the dial's readings [mm]; without a generator there is no noise."""
    force = forces(**steps)
    x = positions(
        tuple(force.tolist()), stiffness=stiffness, half_play=half_play, friction=friction
    )
    x = x if rng is None else x + noise * rng.standard_normal(len(x))
    x = x + drift * np.linspace(0, 1, len(x)) + 0.3
    return force, x if division is None else np.round(x / division) * division


def text(force, reading, head="# unit: mm\n# resolution: 0.001\n"):
    rows = [f"{F:g},{x:.3f}" for F, x in zip(force, reading, strict=True)]
    return head + "force_N,reading\n" + "\n".join(rows) + "\n"
