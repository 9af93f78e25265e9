"""Connects to a Dask cluster, and checks its workers."""

from collections.abc import Iterator
from concurrent.futures import Executor
import contextlib
from typing import Any

from hunav_drake.trial.provenance import Provenance, program_versions

# Time limits for the scheduler and for its first worker, in seconds.
_SCHEDULER, _WORKER = 10, 30


class ClusterError(ConnectionError):
    """A cluster cannot be used; the message has reason and remedy."""


@contextlib.contextmanager
def connect(address: str) -> Iterator[tuple[Executor, int]]:
    """Yields the executor of a Dask cluster, and its number of processors.

    Args:
        address: The address of the scheduler, host:port.

    Raises:
        ClusterError: If there is no scheduler or worker, or the workers have
            other versions than this process.
    """
    from distributed import Client

    with contextlib.ExitStack() as stack:
        try:
            client = stack.enter_context(Client(address, timeout=_SCHEDULER))
        except (OSError, TimeoutError, ValueError) as error:
            raise ClusterError(
                f"no Dask scheduler answers: {error}; start one"
                " with `dask scheduler`, and workers with `dask worker`"
            ) from error
        check_workers(client)
        with client.get_executor(pure=False) as executor:
            yield executor, sum(client.ncores().values())


def check_workers(client: Any) -> None:
    """Checks that the workers of a cluster have the same versions.

    Args:
        client: A `distributed.Client`.

    Raises:
        ClusterError: If not.
    """
    try:
        client.wait_for_workers(1, timeout=_WORKER)
    except TimeoutError as error:
        raise ClusterError(
            f"the cluster had no worker for {_WORKER} s: start some with"
            " `dask worker`"
        ) from error
    here = program_versions()
    found = client.run(program_versions, on_error="return")
    faults: dict[str, list[str]] = {}
    for worker, versions in sorted(found.items()):
        if fault := _fault(here, versions):
            faults.setdefault(fault, []).append(worker)
    if faults:
        told = "; ".join(
            f"{fault}, on {len(workers)} of {len(found)} workers ({workers[0]})"
            for fault, workers in faults.items()
        )
        raise ClusterError(
            "the workers differ from this process, so results would differ,"
            f" too: {told}"
        )


def _fault(here: Provenance, there: Provenance | Exception) -> str:
    if isinstance(there, Exception):
        return f"{type(there).__name__}: {there}"
    return ", ".join(
        f"{key} is {there.get(key)}, not {value}"
        for key, value in here.items()
        if there.get(key) != value
    )
