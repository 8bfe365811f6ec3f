"""Where many tables are worked on: processes of this machine, or a cluster of Dask."""

from __future__ import annotations

import asyncio
import multiprocessing
import os
import signal
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import contextmanager
from functools import partial
from multiprocessing.connection import wait
from threading import Thread, current_thread, main_thread
from types import ModuleType
from typing import Any, ParamSpec, TypeVar

from scara_iso.base.errors import ServiceError, UsageError, with_extra
from scara_iso.base.trust import code_folders
from scara_iso.fleets import Engine

Given = ParamSpec("Given")
Answer = TypeVar("Answer")
LOCAL, DASK = "local", "dask://"
_SLOW_TO_IMPORT = ("duckdb", "pandas", "scipy.special", "scara_iso.diagnosis.closed_loop")
_AHEAD = 2
"""Parts under way for each process, so that none waits for the next."""
_PATIENCE = 10
"""Seconds in which a scheduler is to answer."""
_FIRST_WORKER = 60
"""Seconds in which it is to have a worker."""
_REMEDY = "use local, or dask://HOST:PORT of a scheduler"


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
            with _ctrl_c_later(), _nothing_of_this_folder():
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
    context.set_forkserver_preload(["scara_iso.fleets.work", *_SLOW_TO_IMPORT])
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


@contextmanager
def _ctrl_c_later() -> Iterator[None]:
    """Hear Ctrl-C at the end only: nobody would end a process that is half begun."""
    heard: list[Any] = []
    deaf = current_thread() is not main_thread()
    before = None if deaf else signal.signal(signal.SIGINT, lambda *one: heard.append(one))
    try:
        yield
    finally:
        if not deaf:
            signal.signal(signal.SIGINT, before)
    if heard and callable(before):
        before(*heard[0])


def _start_deaf() -> None:
    """Start the server of processes so that it and they leave Ctrl-C to this one."""
    from multiprocessing import forkserver, resource_tracker  # not of every system

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
    wait([sentinel])
    os._exit(1)


@contextmanager
def engine_of(name: str, workers: int | None = None) -> Iterator[Engine]:
    """Yield the engine of a name: ``local``, or ``dask://HOST:PORT`` of a scheduler.

    Raises `UsageError` for another name or without the package for it, `ServiceError` where no
    scheduler answers.
    """
    if name == LOCAL:
        count = workers or os.cpu_count() or 1
        yield Engine(partial(open_processes, count), lambda: _AHEAD * count)
    elif name.startswith(DASK):
        with _cluster(name.removeprefix(DASK)) as engine:
            yield engine
    else:
        raise UsageError(f"`engine={name}`", remedy=_REMEDY)


@contextmanager
def threads_of(name: str, workers: int | None = None) -> Iterator[tuple[Engine, int]]:
    """Yield an engine as `engine_of`, and the threads that DuckDB may take for one part.

    ``local`` is this process: what adds up in threads of its own needs no other.
    """
    if name == LOCAL:
        yield Engine(partial(ThreadPoolExecutor, 1), lambda: 1), workers or os.cpu_count() or 1
    else:
        with engine_of(name) as engine:
            yield engine, 1


@contextmanager
def _cluster(address: str) -> Iterator[Engine]:
    try:
        from distributed import Client
    except ImportError as error:
        raise UsageError("a cluster needs Dask", remedy=with_extra("dask")) from error
    host, _, port = address.rpartition(":")
    if not host or not port.isdecimal():
        raise UsageError(f"`engine={DASK}{address}`", remedy=_REMEDY)
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
    from distributed.comm import connect

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
            remedy=f"start some: dask worker {address}; the same command then goes on",
        ) from error
