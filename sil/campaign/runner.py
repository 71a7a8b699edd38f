# SPDX-License-Identifier: MIT
"""Who sails the batches: processes of this machine, or the workers of a Dask cluster.

Either way each batch's result is noted as it comes, and none is missing in the end: a batch that
loses its process is sailed run by run, and a run that does so alone has failed.
"""

import logging
from collections.abc import Callable, Sequence
from typing import Any

from sil.campaign.work import OtherCodeError, Share, ShareResult, failed, sail_batch
from sil.common import pool

Note = Callable[[ShareResult], None]
_DIED = "the process died"
_TASKS = 4  # for each thread of a cluster


def locally(batches: Sequence[Share], workers: int, note: Note) -> None:
    """Sail batches in `workers` processes of this machine."""

    def told(_: Share, result: ShareResult) -> None:
        note(result)

    for batch in pool.run(sail_batch, batches, workers, told):
        singles = list(batch.singles())
        lost = pool.run(sail_batch, singles, 1, told) if len(singles) > 1 else singles
        for single in lost:
            note(failed(single, _DIED))


def on_cluster(
    batches_for: Callable[[int], Sequence[Share]],
    address: str,
    note: Note,
    say: Callable[[str], object] = print,
) -> int:
    """Sail batches on the Dask cluster whose scheduler is at `address`; its number of threads.

    `batches_for` is told how many it should make, so that none waits long for the last of them.
    Where there is no worker, `say` is told that one is waited for. A worker that dies is made up
    for by the others, as often as the scheduler's `allowed-failures` lets it. OSError where there
    is no scheduler, or it is lost.
    """
    import distributed  # noqa: PLC0415  half a second that a local campaign does not spend

    # what goes wrong is raised, which is told in a line
    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)
    with distributed.Client(address) as client:
        try:
            if not client.nthreads():
                say(f"{address} has no workers: waiting for the first")
                client.wait_for_workers(1)
            _sail(client, batches_for(_TASKS * _threads(client)), note)
            return _threads(client)
        except (OSError, OtherCodeError):
            raise
        except Exception as error:  # Dask has many
            told = str(error).partition("\n")[0]
            raise OSError(f"{address}: {type(error).__name__}: {told}") from None


def _threads(client: Any) -> int:
    threads: int = sum(client.nthreads().values())
    return max(1, threads)


def _sail(client: Any, batches: Sequence[Share], note: Note) -> None:
    from distributed import KilledWorker, as_completed  # noqa: PLC0415

    batch_of: dict[str, Share] = {}

    def submit(some: Sequence[Share]) -> list[Any]:
        futures: list[Any] = client.map(sail_batch, some, pure=False)
        batch_of.update(zip((future.key for future in futures), some, strict=True))
        return futures

    suspects: list[Share] = []
    under_way = as_completed(submit(batches))
    for future in under_way:
        batch = batch_of.pop(future.key)
        if not isinstance(future.exception(), KilledWorker):
            note(future.result())
        elif len(batch.runs) > 1:
            under_way.update(submit(tuple(batch.singles())))
        else:
            suspects.append(batch)
    # Dask blames all that waited on a worker that died: alone, none is blamed for another.
    for batch in suspects:
        (alone,) = submit((batch,))
        killed = isinstance(alone.exception(), KilledWorker)
        note(failed(batch, _DIED) if killed else alone.result())
