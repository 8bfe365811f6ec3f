"""ISO 9283 repeatability of SCARA robots from digital dial indicators.

    >>> import scara_iso
    >>> run = scara_iso.read_table("examples/fum_scara_table1.csv")
    >>> round(scara_iso.analyze(run).poses[0].axes["X"].RP, 5)
    0.01404

There is one function for each command, with its options as keywords: `analyze`, `analyze_many`,
`diagnose`, `diagnose_many`, `fleet`, `gauge_study`, `compare`, `report`, `simulate`, `plan`,
`plan_separating`, `backlash`, `program`, `record`, `visits`, `push`, `history`, `selftest`.
Where a table is wanted they take a path, a `Run` or a pandas table with its unit. Errors
are `ScaraIsoError`s with what, where and what to do.
"""

from importlib import import_module

from scara_iso.base import displayed

displayed.notebook = lambda: import_module("scara_iso.commands.notebook")

__version__ = "1.0.0"


def __getattr__(name: str) -> object:
    return getattr(import_module("scara_iso._names"), name)


def __dir__() -> list[str]:
    return [*__getattr__("__all__"), "__version__"]
