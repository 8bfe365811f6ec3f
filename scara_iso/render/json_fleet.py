"""The summary of a fleet as a JSON object."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scara_iso.published import Json
from scara_iso.render.json import each, picked

if TYPE_CHECKING:
    from scara_iso.fleets import FleetDrift, FleetFigures, FleetSummary

_ROBOT = "robot tables p_value q_value found effects RP_XY"


def fleet_json(found: FleetSummary) -> Json:
    """Return the JSON object of ``fleet``, schema ``scara-iso/fleet/1``: every robot is in it."""
    return {
        "schema": "scara-iso/fleet/1",
        "unit": "mm",
        "folder": str(found.run.folder),
        "parts": picked(found.run, "count=parts done_before=before failed"),
        **picked(found, "tables false_discovery_rate=level found_too_coarse=too_coarse effects"),
        **_quantiles(found),
        "robots": each(found.robots, _ROBOT),
        "twice": each(found.twice, "robot test parts"),
        "names_alone": each(found.names_alone, "name serial_numbers tables"),
        "several_names": each(found.several_names, "robot names"),
        "alike": [list(robots) for robots in found.alike],
        "failed": each(found.failed, "part robot test error"),
        "drift": _drift(found.drift),
    }


def fleet_figures_json(found: FleetFigures) -> Json:
    """Return the JSON object of a fleet's figures alone, schema ``scara-iso/fleet-figures/1``."""
    return {
        "schema": "scara-iso/fleet-figures/1",
        "unit": "mm",
        "folder": str(found.run.folder),
        "files": str(found.files),
        "parts": picked(found.run, "count=parts done_before=before failed"),
        **picked(found, "tables robots"),
        **_quantiles(found),
        "worst": each(found.worst, "robot tables RP"),
        "twice": each(found.twice, "robot test parts"),
        "names_alone": each(found.names_alone, "name serial_numbers tables"),
        "several_names": each(found.several_names, "robot names"),
        "alike": [list(robots) for robots in found.alike],
        "failed": each(found.failed, "part robot test error"),
        "drift": _drift(found.drift),
    }


def _drift(found: FleetDrift | None) -> Json | None:
    if found is None:
        return None
    return {
        **picked(found, "figure robots per_month interval"),
        "periods": each(found.periods, "period robots RP_quantiles compared worse"),
        "asked": found.asked,
        "growing": each(found.growing, "robot dates per_month p_value q_value"),
    }


def _quantiles(found: FleetSummary | FleetFigures) -> Json:
    return {
        "RP_quantiles": picked(found, "RP_quantiles")["RP_quantiles"],
        "quantiles": [0.05, 0.25, 0.5, 0.75, 0.95],
    }
