# SPDX-License-Identifier: MIT
"""Sails batches in processes of this machine, or on the workers of a Dask cluster.

Either way each batch's result is noted as it arrives, and none is missing in the end. If a batch
loses its process, its runs are sailed one by one; a run that loses its process alone has failed.
"""

import logging
from collections.abc import Callable, Sequence
from typing import Any

from sil.campaign.work import OtherCodeError, Share, ShareResult, failed, sail_batch
from sil.common import pool

Note = Callable[[ShareResult], None]
_DIED = "the process died"
_TASKS = 4  # tasks for each thread of a cluster


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
    """Sail batches on the Dask cluster whose scheduler is at `address`; return its thread count.

    `batches_for` makes the requested number of batches, so that none waits long for the last one.
    If there is no worker, reports to `say` that it waits for the first. Other workers replace one
    that dies, as often as the scheduler's `allowed-failures` permits. OSError if there is no
    scheduler, or its connection is lost.
    """
    import distributed  # noqa: PLC0415 takes half a second, which a local campaign saves

    # errors are raised, and reported in one line
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
        except Exception as error:  # Dask raises many types
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
    # Dask blames every batch that waited on the dead worker; alone, a batch is blamed only for
    # itself.
    for batch in suspects:
        (alone,) = submit((batch,))
        killed = isinstance(alone.exception(), KilledWorker)
        note(failed(batch, _DIED) if killed else alone.result())
