"""The one seam to where the work is done: an `Executor`, opened anew where it broke.

A process that dies breaks its pool and takes down what was under way in it. Those parts are then
done alone, each in a pool of its own: only the part that kills its process again is given up.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, wait
from typing import TypeVar

from scara_iso.frozen import dataclass

Result = TypeVar("Result")
_TRIES = 2


@dataclass(frozen=True, slots=True)
class Engine:
    """Where the work is done: how an executor of it is opened, and how much is under way."""

    open: Callable[[], Executor]
    under_way: int


def done_by(
    engine: Engine, work: Callable[[str], Result], parts: Sequence[str]
) -> Iterator[tuple[str, Result | Exception]]:
    """Yield each part once, as it is done, with its result or what became of it."""
    waiting = deque(parts)
    while waiting:
        with engine.open() as executor:
            suspects = yield from _until_broken(executor, engine.under_way, work, waiting)
        for part in suspects:
            yield part, _alone(engine, work, part)


def _until_broken(
    executor: Executor, under_way: int, work: Callable[[str], Result], waiting: deque[str]
) -> Generator[tuple[str, Result | Exception], None, list[str]]:
    """Yield what is done; return what was under way where the executor broke, else nothing."""
    running: dict[Future[Result], str] = {}
    broken = False
    while running or (waiting and not broken):
        while waiting and len(running) < under_way and not broken:
            try:
                running[executor.submit(work, waiting[0])] = waiting[0]
                waiting.popleft()
            except BrokenExecutor:
                broken = True
        finished, _ = wait(running, return_when=FIRST_COMPLETED)
        outcomes: dict[Future[Result], Result | Exception] = {}
        for future in finished:
            outcome = _outcome(future)
            outcomes[future] = outcome
        if broken or any(isinstance(one, BrokenExecutor) for one in outcomes.values()):
            return list(running.values())
        yield from ((running.pop(future), outcome) for future, outcome in outcomes.items())
    return []


def _outcome(future: Future[Result]) -> Result | Exception:
    error = future.exception()
    if error is None:
        return future.result()
    if isinstance(error, Exception):
        return error
    raise error


def _alone(engine: Engine, work: Callable[[str], Result], part: str) -> Result | Exception:
    failed: Exception = RuntimeError("not tried")
    for _ in range(_TRIES):
        with engine.open() as executor:
            try:
                return executor.submit(work, part).result()
            except BrokenExecutor as error:
                failed = error
            except Exception as error:  # noqa: BLE001 - of the part, and reported with it
                return error
    return failed
