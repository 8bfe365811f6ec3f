"""A simulated indicator as a port: ``sim:``, which speaks its dialect and needs no hardware.

The keyboard as a port: each line that the operator types, or a cable types for it.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from decimal import Decimal
from pathlib import Path
from typing import TypeAlias

from scara_iso.base.errors import UsageError
from scara_iso.base.quantities import Unit, parse_unit
from scara_iso.recorder.indicators import Dialect, LinePulse, find_dialect
from scara_iso.recorder.ports.port import Clock, Port, number_option, split_options


class KeyboardPort(Port):
    """Hands on the lines of ``typed``, one a call; the operator ends the session, not the port."""

    address = identity = "keyboard:"

    def __init__(self, typed: Callable[[], bytes] | None) -> None:
        if typed is None:
            raise UsageError(
                "a keyboard port takes no readings here",
                where=self.address,
                remedy="scara-iso record takes what is typed, or the lines of standard input",
            )
        self._typed = typed

    def read(self) -> bytes:
        """Return the next line."""
        return self._typed()


OPTIONS = {
    "value": "value it scatters around [mm]",
    "scatter": "standard deviation [mm], default 0.004",
    "unit": "unit of its display",
    "seed": "whole number, default 0",
    "every": "seconds between readings that it sends by itself",
    "model": "model file (.toml) that gives the values, instead of value and scatter",
    "pace": "0 for as fast as possible, 1 (default) for real time",
}
ANSWER_S = 0.02
_SHORTEST_S = 0.001
MODEL_CYCLES = 10_000
"""As many cycles are computed of a model; the last one is shown ever after."""
AT_REST_S = 0.05
"""Asked again within this time after an answer, the arm has not moved: the same value [s]."""
VISIT_S = 4.0
"""Where the dial's rest is watched, the arm leaves, comes back and stands in this time [s]."""
_AWAY, _COMING = 0.4, 0.45
AWAY = 2.0
"""How far from the pose the dial then shows the arm to be [mm or deg]."""

Signal: TypeAlias = Callable[[int], float]
"""The value that the indicator shows at the k-th pose attained, k from 0 [mm or deg]."""


class SimulatedPort(Port):
    """Answers each request, or sends by itself where the session only listens.

    ``source`` gives the values, by default scatter around a value with a slight warm-up. The
    same address, axis and requests give the same bytes.
    """

    simulated = unit_confirmed = True

    def __init__(
        self,
        address: str,
        dialect: Dialect,
        *,
        axis: str,
        clock: Clock,
        asked: bool,
        source: Signal | None = None,
        watched: bool = False,
    ) -> None:
        key, options = split_options(address.removeprefix("sim:"), OPTIONS)
        self._dialect = find_dialect(key) if key else dialect
        self.address = address
        self.identity = f"{address} (simulated)"
        self.unit: str | None = options.get("unit") or self._dialect.units[0] or "mm"
        self._size = parse_unit(self.unit)
        if None not in self._dialect.units and self.unit not in self._dialect.units:
            known = ", ".join(map(str, self._dialect.units))
            raise UsageError(
                f"{self._dialect.key} cannot show {self.unit}",
                where=address,
                remedy=f"it knows {known}",
            )
        self._source = source or _source(axis, options, self._size)
        self._clock = clock
        self._watched = watched
        self._poses = 0
        self._position = 0.0
        self._text = ""
        self._answered = -math.inf
        self._answer_at = math.inf
        self._every = number_option(options, "every", 0.3 if asked else 1.0) or 1.0
        if self._every < _SHORTEST_S:
            raise UsageError(
                f"every={options['every']} is less than {_SHORTEST_S} s",
                remedy=f"write every={_SHORTEST_S}, or more",
            )
        self._push_at = math.inf if asked and self._dialect.asks else clock.now() + self._every
        clock.watch(lambda: min(self._answer_at, self._push_at))

    def read(self) -> bytes:
        """Return the frame whose time has come."""
        now = self._clock.now()
        if now >= self._answer_at:
            self._answer_at = math.inf
        elif now >= self._push_at:
            self._push_at += self._every
        else:
            return b""
        if self._watched:
            self._text = self._on_the_way(now)
        elif now - self._answered > AT_REST_S:
            self._text = self._shown(self._source(self._poses))
            self._poses += 1
        self._answered = now
        frame_unit = self.unit if self.unit in self._dialect.units else None
        return self._dialect.compose(self._text, frame_unit, self._dialect.channel)

    def write(self, data: bytes) -> None:
        """Take a request; anything else is not understood and not answered."""
        if data == self._dialect.request:
            self._answer_at = self._clock.now() + ANSWER_S

    def pulse(self, pulse: LinePulse) -> None:  # noqa: ARG002 - any pulse is a request
        """Take the request."""
        self._answer_at = self._clock.now() + ANSWER_S

    def _on_the_way(self, now: float) -> str:
        """Return the display of an arm that is away, comes, and stands at the pose, alternately."""
        visit, phase = divmod(now / VISIT_S, 1.0)
        if visit >= self._poses:
            self._poses = int(visit) + 1
            self._position = self._source(int(visit))
        away = min(1.0, max(0.0, (_COMING - phase) / (_COMING - _AWAY)))
        return self._shown(self._position + away * AWAY)

    def _shown(self, position: float) -> str:
        value = position * self._size.denominator / self._size.numerator
        shown = round(Decimal(value), self._dialect.decimals[0])
        return f"{shown if shown else abs(shown):f}"


def _source(axis: str, options: dict[str, str], unit: Unit) -> Signal:
    seed = options.get("seed", "0")
    if not (seed.isascii() and seed.isdigit() and len(seed) < 19):
        raise UsageError(
            f"seed={seed} is not a whole number", remedy="write a whole number, as seed=1"
        )
    if "model" in options:
        return of_model(Path(options["model"]), axis, unit, int(seed))
    return scatter(axis, options, int(seed))


def of_model(path: Path, axis: str, unit: Unit, seed: int) -> Signal:
    """Return the readings that a model file predicts, with its scatter; the same for every axis.

    Raises what `read_model` raises, and `UsageError` where the model has no such axis.
    """
    import numpy as np  # noqa: PLC0415 - only where a model is named

    from scara_iso.effects import Conditions  # noqa: PLC0415
    from scara_iso.robot import read_model, simulate  # noqa: PLC0415

    rng = np.random.default_rng(seed)
    run = simulate(read_model(path), Conditions(np.arange(1, MODEL_CYCLES + 1), {}), rng=rng)
    column = run.axes.get(axis)
    if column is None or column.dimension is not unit.dimension:
        raise UsageError(
            f"the model has no axis {axis} in {unit.base_name}",
            where=str(path),
            remedy=f"its axes: {', '.join(f'{a.name} in {a.unit}' for a in run.axes.values())}",
        )
    readings = column.readings.tolist()
    return lambda k: float(readings[min(k, MODEL_CYCLES - 1)])


def scatter(axis: str, options: dict[str, str], seed: int) -> Signal:
    """Return readings that warm up by 3 um over the first ten poses and scatter around a value."""
    noise = random.Random(f"{axis}/{seed}")  # noqa: S311 - readings, not secrets
    value = number_option(options, "value", round(noise.uniform(0.2, 0.9), 3))
    deviation = number_option(options, "scatter", 0.004)
    return lambda k: value + 0.003 * (1 - math.exp(-k / 10)) + noise.gauss(0.0, deviation)
