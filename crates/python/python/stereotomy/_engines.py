"""Who does the work: a Ray or a Dask cluster, an executor, or processes of this machine."""

from __future__ import annotations

import contextlib
import importlib
import pickle
from collections.abc import Callable, Generator, Iterator, Sequence

# Type checkers know the names; `typing` itself would be most of the time that an import takes.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

# How often what was lost with its worker is done once more; of processes of this machine, how often
# all begin again without anything having been done.
RETRIES = 3
# Seconds in which a task may end by itself before it is cancelled.
SOON = 1.0
# Items per worker that are under way at a time: results that nobody has fetched take memory.
AHEAD = 2


def engine(client: object) -> Engine:
    """The engine of a client."""
    if client is None:
        return Processes()
    if getattr(client, "__name__", None) == "ray":
        return Ray(client)
    if any(kind.__module__.split(".")[0] == "distributed" for kind in type(client).__mro__):
        return Dask(client)
    executors = importlib.import_module("concurrent.futures")
    if isinstance(client, executors.Executor):
        return Pool(client)
    raise TypeError(
        f"client: {type(client).__name__} is none; give the module ray after ray.init(), a "
        "dask.distributed.Client, a concurrent.futures.Executor, or None for processes of "
        "this machine"
    )


_unpickled: tuple[bytes, Any] | None = None


def _call(function: Callable[..., Any], shared: bytes, item: tuple[Any, ...]) -> Any:
    """The function's result; what items share is unpickled once."""
    global _unpickled
    known = _unpickled
    if known is None or known[0] != shared:
        known = (shared, pickle.loads(shared))
        _unpickled = known
    return function(known[1], *item)


class Engine:
    """Does a function for every item, some ahead of the results that are fetched."""

    workers: int

    def _submit(self, function: Callable[..., Any], item: tuple[Any, ...]) -> Any:
        raise NotImplementedError

    def _share(self, shared: bytes) -> None:
        raise NotImplementedError

    def _wait(self, futures: list[Any]) -> list[Any]:
        """Those that are done, one at least."""
        raise NotImplementedError

    def _result(self, future: Any) -> Any:
        raise NotImplementedError

    def _cancel(self, futures: list[Any]) -> None:
        raise NotImplementedError

    def run(
        self, function: Callable[..., Any], shared: bytes, items: Sequence[tuple[Any, ...]]
    ) -> Generator[tuple[int, Any]]:
        """Each result with its item's place, as soon as it is done; `shared` is the pickle of
        what all items have in common. Whoever does not want all of them closes it, which
        cancels the rest."""
        self._share(shared)
        waiting = iter(enumerate(items))
        under_way: dict[Any, int] = {}
        try:
            while True:
                for index, item in waiting:
                    under_way[self._submit(function, item)] = index
                    if len(under_way) >= AHEAD * self.workers:
                        break
                if not under_way:
                    return
                for future in self._wait(list(under_way)):
                    result = self._result(future)
                    yield under_way.pop(future), result
        finally:
            self._cancel(list(under_way))


class Ray(Engine):
    """A Ray cluster; `ray` is the module, after `ray.init()`."""

    def __init__(self, ray: Any) -> None:
        if not ray.is_initialized():
            raise ValueError("client: ray has no cluster yet: call ray.init() first")
        self.ray = ray
        self.workers = max(1, int(ray.cluster_resources().get("CPU", 1)))
        # (What raises is not tried again, what dies is.)
        self.remote = ray.remote(max_retries=RETRIES)(_call)

    def _share(self, shared: bytes) -> None:
        self.shared = self.ray.put(shared)

    def _submit(self, function: Callable[..., Any], item: tuple[Any, ...]) -> Any:
        return self.remote.remote(function, self.shared, item)

    def _wait(self, futures: list[Any]) -> list[Any]:
        done: list[Any] = self.ray.wait(futures, num_returns=1)[0]
        return done

    def _result(self, future: Any) -> Any:
        try:
            return self.ray.get(future)
        except self.ray.exceptions.RayTaskError as error:
            # What the function raised, without the way that it came.
            raise error.cause from None

    def _cancel(self, futures: list[Any]) -> None:
        """Those that do not end soon: Ray's core ends this process if a task is done just while it
        is cancelled (https://github.com/ray-project/ray/pull/54798). The last first, so that
        none begins as a worker is free."""
        if futures:
            _, left = self.ray.wait(futures, num_returns=len(futures), timeout=SOON)
            for future in reversed(left):
                # (What a worker is doing stops as by Ctrl-C.)
                self.ray.cancel(future)


class Futures(Engine):
    """What gives futures as `concurrent.futures` has them, which `wait` waits for."""

    wait: Callable[..., Any]

    def _wait(self, futures: list[Any]) -> list[Any]:
        return list(self.wait(futures, return_when="FIRST_COMPLETED").done)

    def _result(self, future: Any) -> Any:
        return future.result()

    def _cancel(self, futures: list[Any]) -> None:
        for future in futures:
            future.cancel()


class Dask(Futures):
    """A Dask cluster, by a `distributed.Client`. Workers that die are the scheduler's affair:
    it gives what they did to others."""

    def __init__(self, client: Any) -> None:
        self.client = client
        self.workers = max(1, sum(client.nthreads().values()))
        self.wait = importlib.import_module("distributed").wait

    def _share(self, shared: bytes) -> None:
        # A task, not data: it can be made again where its worker died.
        self.shared = self.client.submit(bytes, shared, pure=False)

    def _submit(self, function: Callable[..., Any], item: tuple[Any, ...]) -> Any:
        return self.client.submit(_call, function, self.shared, item, pure=False)


class Pool(Futures):
    """Any executor of `concurrent.futures`. What is lost with its worker is lost."""

    def __init__(self, executor: Any) -> None:
        import os

        self.executor = executor
        self.workers = getattr(executor, "_max_workers", None) or os.cpu_count() or 1
        self.wait = importlib.import_module("concurrent.futures").wait

    def _share(self, shared: bytes) -> None:
        self.shared = shared

    def _submit(self, function: Callable[..., Any], item: tuple[Any, ...]) -> Any:
        return self.executor.submit(_call, function, self.shared, item)


# Seconds that a process which is told to stop has to put away what it was writing.
GRACE = 2.0
_of_process: bytes = b""
_is_working = False


class _Stopped(SystemExit):
    """In a process that is told to stop."""


def _start(shared: bytes, lifeline: Any) -> None:
    """Begins a process of this machine. It stops when the other end of its lifeline is closed, be
    it that the process which has it ends."""
    global _of_process
    import signal
    import threading

    _of_process = shared
    # Ctrl-C reaches all processes of a terminal; the one that started this one heeds it.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, _stop)
    threading.Thread(target=_watch, args=(lifeline,), daemon=True).start()


def _stop(number: int, frame: object) -> None:
    import os
    import signal

    if not _is_working:
        os._exit(1)
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    raise _Stopped


def _watch(lifeline: Any) -> None:
    import os
    import signal
    import threading
    import time

    with contextlib.suppress(EOFError, OSError):
        lifeline.recv_bytes()
    main = threading.main_thread().ident
    if main is not None and hasattr(signal, "pthread_kill"):
        signal.pthread_kill(main, signal.SIGTERM)
        time.sleep(GRACE)
    _put_away()
    os._exit(1)


def _put_away() -> None:
    """Removes files that this process has not written to their end, where the system tells which."""
    import os

    with contextlib.suppress(OSError):
        for number in os.listdir("/proc/self/fd"):
            with contextlib.suppress(OSError):
                path = os.readlink(f"/proc/self/fd/{number}")
                if os.path.basename(path).startswith(".unfinished-"):
                    os.remove(path)


def _call_here(function: Callable[..., Any], item: tuple[Any, ...]) -> Any:
    global _is_working
    import os

    try:
        _is_working = True
        return _call(function, _of_process, item)
    except _Stopped:
        # (The executor would take the exception for the result, and go on.)
        os._exit(1)
    finally:
        _is_working = False


@contextlib.contextmanager
def _ctrl_c_waits() -> Iterator[None]:
    """Ctrl-C waits until this is over, and processes that are started meanwhile never hear of it."""
    import signal

    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


class Processes(Pool):
    """Processes of this machine, one for each processor; new ones, if any dies."""

    def __init__(self) -> None:
        import os

        self.workers = os.cpu_count() or 1
        self.wait = importlib.import_module("concurrent.futures").wait

    def _submit(self, function: Callable[..., Any], item: tuple[Any, ...]) -> Any:
        # (This starts processes, each of which has what is shared from its start.)
        with _ctrl_c_waits():
            return self.executor.submit(_call_here, function, item)

    def _cancel(self, futures: list[Any]) -> None:
        """Nothing: they end with their processes. (An executor that loses these while it has
        cancelled futures leaves some behind: https://github.com/python/cpython/pull/108974.)"""

    def run(
        self, function: Callable[..., Any], shared: bytes, items: Sequence[tuple[Any, ...]]
    ) -> Generator[tuple[int, Any]]:
        from concurrent.futures import ProcessPoolExecutor
        from concurrent.futures.process import BrokenProcessPool
        from multiprocessing import get_context

        left = dict(enumerate(items))
        failures = 0
        context = get_context("spawn")
        while left:
            lifeline, end = context.Pipe(duplex=False)
            workers = min(self.workers, len(left))
            try:
                with (
                    lifeline,
                    end,
                    ProcessPoolExecutor(workers, context, _start, (shared, lifeline)) as executor,
                ):
                    self.executor = executor
                    places = list(left)
                    try:
                        for at, result in super().run(function, shared, list(left.values())):
                            del left[places[at]]
                            failures = 0
                            yield places[at], result
                    except BaseException:
                        # (Before the executor waits for them.)
                        end.close()
                        raise
            except BrokenProcessPool:
                failures += 1
                if failures > RETRIES:
                    raise
