"""The one seam to where the work is done: an `Executor`, opened anew where it broke.

A process that dies breaks its pool and takes down what was under way in it. Those items are then
done alone, each in a pool of its own: only the one that kills its process again is given up.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    wait,
)
from dataclasses import dataclass
from typing import TypeVar

from scara_iso.errors import ServiceError
from scara_iso.fleets.pieces import Share

Item = TypeVar("Item")
Result = TypeVar("Result")
_TRIES = 2
_GONE = "the cluster has gone away"
_GO_ON = "start it again; the same command then goes on where it stopped"
_LOOK_AGAIN = 10
"""Seconds after which it is looked who is there, where nothing is done meanwhile."""
_ROUNDS = 2
"""At least so often all that can be under way is: more evens the load, and reads a part oftener."""


@dataclass(frozen=True, slots=True)
class Engine:
    """Where the work is done: how an executor of it is opened, and how much is under way."""

    open: Callable[[], Executor]
    under_way: Callable[[], int]
    """Of the moment: a cluster grows and shrinks. Raises `ServiceError` where nobody is left."""

    def shares_of_each(self, several: int) -> list[Share]:
        """Return the shares in which each of several is given out, so that nobody waits long."""
        count = math.ceil(_ROUNDS * self.under_way() / max(several, 1))
        return [Share(number, count) for number in range(count)]


def done_by(
    engine: Engine, work: Callable[[Item], Result], items: Sequence[Item]
) -> Iterator[tuple[Item, Result | Exception]]:
    """Yield each item once, as it is done, with its result or what became of it."""
    waiting = deque(items)
    while waiting:
        with engine.open() as executor:
            try:
                suspects = yield from _until_broken(executor, engine.under_way, work, waiting)
            except ServiceError:
                executor.shutdown(wait=False)  # nobody is left to wait for
                raise
        for item in suspects:
            yield item, _alone(engine, work, item)


def _until_broken(
    executor: Executor,
    under_way: Callable[[], int],
    work: Callable[[Item], Result],
    waiting: deque[Item],
) -> Generator[tuple[Item, Result | Exception], None, list[Item]]:
    """Yield what is done; return what was under way where the executor broke, else nothing."""
    running: dict[Future[Result], Item] = {}
    broken = False
    while running or (waiting and not broken):
        room = under_way()
        while waiting and len(running) < room and not broken:
            try:
                running[executor.submit(work, waiting[0])] = waiting[0]
                waiting.popleft()
            except BrokenExecutor:
                broken = True
        finished, _ = wait(running, _LOOK_AGAIN, return_when=FIRST_COMPLETED)
        outcomes: dict[Future[Result], Result | Exception] = {}
        for future in finished:
            outcome = _outcome(future)
            outcomes[future] = outcome
        if broken or any(isinstance(one, BrokenExecutor) for one in outcomes.values()):
            return list(running.values())
        yield from ((running.pop(future), outcome) for future, outcome in outcomes.items())
    return []


def _outcome(future: Future[Result]) -> Result | Exception:
    try:
        error = future.exception()
    except CancelledError as gone:  # nothing here cancels
        raise ServiceError(_GONE, remedy=_GO_ON) from gone
    if error is None:
        return future.result()
    if isinstance(error, Exception):
        return error
    raise error


def _alone(engine: Engine, work: Callable[[Item], Result], item: Item) -> Result | Exception:
    failed: Exception = RuntimeError("not tried")
    for _ in range(_TRIES):
        with engine.open() as executor:
            found = _outcome(executor.submit(work, item))
        if not isinstance(found, BrokenExecutor):
            return found
        failed = found
    return failed
