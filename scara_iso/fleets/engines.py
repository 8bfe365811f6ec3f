"""Where many tables are worked on: processes of this machine, or a cluster of Dask.

The one seam is an `Executor`, opened anew where it broke. A process that dies breaks its pool and
takes down what was under way in it. Those items are then done one at a time: only the one that
kills its process again is given up.
"""

import asyncio
import multiprocessing
import os
import signal
import sys
from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ProcessPoolExecutor,
    ThreadPoolExecutor,
    wait,
)
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from multiprocessing import connection
from threading import Thread
from types import ModuleType
from typing import Any, ParamSpec, TypeVar

from scara_iso.base.errors import ServiceError, UsageError, with_extra
from scara_iso.base.process import Later, code_folders

Given = ParamSpec("Given")
Answer = TypeVar("Answer")
Item = TypeVar("Item")
LOCAL, DASK = "local", "dask://"
_SLOW_TO_IMPORT = ("duckdb", "pandas", "scipy.special", "scara_iso.diagnosis.closed_loop")
_AHEAD = 2
"""Parts under way for each process, so that none waits for the next."""
_PATIENCE = 10
"""Seconds in which a scheduler is to answer."""
_FIRST_WORKER = 60
"""Seconds in which it is to have a worker."""
_REMEDY = "use local, or dask://HOST:PORT of a scheduler"
_ALLOWED = 3
"""Processes that may die with an item, before it is given up; as Dask's `allowed-failures`."""
_GONE = "the cluster has gone away"
_GO_ON = "start it again; the same command then continues where it stopped"
_LOOK_AGAIN = 10
"""Seconds after which it is looked who is there, where nothing is done meanwhile."""


@dataclass(frozen=True, slots=True)
class Engine:
    """Where the work is done: how an executor of it is opened, and how much is under way."""

    open: Callable[[], Executor]
    under_way: Callable[[], int]
    """Of the moment: a cluster grows and shrinks. Raises `ServiceError` where nobody is left."""


def done_by(
    engine: Engine, work: Callable[[Item], Answer], items: Sequence[Item]
) -> Iterator[tuple[Item, Answer | Exception]]:
    """Yield each item once, as it is done, with its result or what became of it."""
    waiting, deaths = deque(items), Counter[Item]()
    while waiting:
        running: dict[Future[Answer], Item] = {}
        with engine.open() as executor:
            try:
                yield from _until_broken(executor, engine.under_way, work, waiting, running, deaths)
            except BrokenExecutor as error:
                deaths.update(running.values())
                lost = list(running.values())
                waiting.extendleft(item for item in lost if deaths[item] < _ALLOWED)
                given_up = [(item, error) for item in lost if deaths[item] >= _ALLOWED]
            except ServiceError:
                executor.shutdown(wait=False)  # nobody is left to wait for
                raise
            else:
                return
        yield from given_up


def _until_broken(
    executor: Executor,
    under_way: Callable[[], int],
    work: Callable[[Item], Answer],
    waiting: deque[Item],
    running: dict[Future[Answer], Item],
    deaths: Counter[Item],
) -> Iterator[tuple[Item, Answer | Exception]]:
    """Yield what is done; raises `BrokenExecutor`, and leaves in ``running`` what was under way."""
    while running or waiting:
        room = under_way()
        while waiting and len(running) < _most([waiting[0], *running.values()], deaths, room):
            running[executor.submit(work, waiting[0])] = waiting[0]
            waiting.popleft()
        finished, _ = wait(running, _LOOK_AGAIN, return_when=FIRST_COMPLETED)
        for future in finished:
            outcome = _outcome(future)
            yield running.pop(future), outcome


def _most(items: Sequence[Item], deaths: Counter[Item], room: int) -> int:
    """Return how many may be under way: one with which a process has died is so alone."""
    return 1 if any(deaths[item] for item in items) else room


def _outcome(future: Future[Answer]) -> Answer | Exception:
    try:
        error = future.exception()
    except CancelledError as gone:  # nothing here cancels
        raise ServiceError(_GONE, remedy=_GO_ON) from gone
    if error is None:
        return future.result()
    if isinstance(error, BrokenExecutor) or not isinstance(error, Exception):
        raise error
    return error


class _Processes(ProcessPoolExecutor):
    """A pool whose processes do not run the user's script, which need not be guarded for that.

    Left by Ctrl-C or an error it ends them: what they were at is done again by the next run.
    """

    def submit(
        self, work: Callable[Given, Answer], /, *args: Given.args, **options: Given.kwargs
    ) -> Future[Answer]:
        """Hand over work; a process that starts for it finds an empty ``__main__``."""
        script = sys.modules["__main__"]
        sys.modules["__main__"] = ModuleType("__main__")
        try:
            with Later(), _nothing_of_this_folder():  # none is left half begun
                return super().submit(work, *args, **options)
        finally:
            sys.modules["__main__"] = script

    def __exit__(self, kind: type[BaseException] | None, *raised: Any) -> bool | None:
        for process in list((self._processes or {}).values()) if kind is not None else []:
            process.terminate()
        return super().__exit__(kind, *raised)


def open_processes(workers: int | None = None) -> Executor:
    """Return a pool of processes that start from nothing: nothing of this one is copied."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # theirs: the processes share the cores
    methods = multiprocessing.get_all_start_methods()
    context = multiprocessing.get_context("forkserver" if "forkserver" in methods else "spawn")
    context.set_forkserver_preload(["scara_iso.fleets.screening", *_SLOW_TO_IMPORT])
    with _nothing_of_this_folder():
        if "forkserver" in methods:
            _start_deaf()
        return _Processes(workers, mp_context=context, initializer=_leave_with_parent)


@contextmanager
def _nothing_of_this_folder() -> Iterator[None]:
    """Let processes that start meanwhile take no code from the folder in which this one stands."""
    path, safe = sys.path, os.environ.get("PYTHONSAFEPATH")
    sys.path, os.environ["PYTHONSAFEPATH"] = code_folders(), "1"
    try:
        yield
    finally:
        sys.path = path
        if safe is None:
            del os.environ["PYTHONSAFEPATH"]
        else:
            os.environ["PYTHONSAFEPATH"] = safe


def _start_deaf() -> None:
    """Start the server of processes so that it and they leave Ctrl-C to this one."""
    from multiprocessing import forkserver, resource_tracker  # noqa: PLC0415 - not of every system

    resource_tracker.ensure_running()  # it would undo what is blocked
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        forkserver.ensure_running()
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _leave_with_parent() -> None:
    """End this process when the one that started it dies: nobody would ever tell it to."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        Thread(target=_leave_after, args=(parent.sentinel,), daemon=True).start()


def _leave_after(sentinel: int) -> None:
    connection.wait([sentinel])
    os._exit(1)


@contextmanager
def engine_of(
    name: str, workers: int | None = None, *, in_process: bool = False
) -> Iterator[Engine]:
    """Yield the engine of a name: ``local``, or ``dask://HOST:PORT`` of a scheduler.

    ``in_process`` has ``local`` work in this process: DuckDB has threads of its own. Raises
    `UsageError` for another name or without the package for it, `ServiceError` where no scheduler
    answers.
    """
    if name == LOCAL and in_process:
        yield Engine(partial(ThreadPoolExecutor, 1), lambda: 1)
    elif name == LOCAL:
        count = workers or cores()
        yield Engine(partial(open_processes, count), lambda: _AHEAD * count)
    elif name.startswith(DASK):
        with _cluster(name.removeprefix(DASK)) as engine:
            yield engine
    else:
        raise UsageError(f"`engine={name}` is not known", remedy=_REMEDY)


def cores() -> int:
    """Return how many cores there are."""
    return os.cpu_count() or 1


@contextmanager
def _cluster(address: str) -> Iterator[Engine]:
    try:
        from distributed import Client  # noqa: PLC0415 - an extra
    except ImportError as error:
        raise UsageError("a cluster needs Dask", remedy=with_extra("dask")) from error
    host, _, port = address.rpartition(":")
    if not host or not port.isdecimal():
        raise UsageError(f"`engine={DASK}{address}`: not HOST:PORT", remedy=_REMEDY)
    start = "start one: dask scheduler, and dask worker HOST:PORT on each machine"
    try:
        with ThreadPoolExecutor(1) as apart:  # a notebook has a loop of its own
            apart.submit(asyncio.run, _met(f"tcp://{address}")).result()
        client = Client(f"tcp://{address}", timeout=_PATIENCE, set_as_default=False)
    except Exception as error:
        raise ServiceError("no Dask scheduler answers", where=address, remedy=start) from error
    try:
        open_executor = partial(client.get_executor, pure=False)
        yield Engine(open_executor, lambda: _AHEAD * _threads(client, address))
    finally:
        client.close(timeout=_PATIENCE)


async def _met(address: str) -> None:
    """Return once a scheduler has spoken: a client would wait for what only listens."""
    from distributed.comm import connect  # noqa: PLC0415 - an extra

    line = await asyncio.wait_for(connect(address, timeout=_PATIENCE), _PATIENCE)
    await line.close()


def _threads(client: Any, address: str) -> int:
    """Return how many tables the cluster works on at once, as far as it has come up.

    Raises `ServiceError` where it has no worker for a minute.
    """
    try:
        client.wait_for_workers(1, timeout=_FIRST_WORKER)
        return max(sum(map(int, client.nthreads().values())), 1)
    except (OSError, TimeoutError) as error:
        raise ServiceError(
            f"the scheduler has had no worker for {_FIRST_WORKER} s",
            where=address,
            remedy=f"start some: dask worker {address}; the same command then continues",
        ) from error
