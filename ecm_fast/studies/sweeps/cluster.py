"""An executor on dask's ``distributed``, with retries of lost work."""

from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from typing import Any

from ...errors import InputError, shown

__all__ = ["cluster"]

_PATIENCE = 10.0  # [s] for a scheduler to answer
_RETRIES = 10  # of a chunk whose worker was lost


@contextmanager
def cluster(address: str) -> Iterator[tuple[Executor, int]]:
    """Connect to a scheduler; yields its executor and how many threads its workers have now.

    Parameters
    ----------
    address : such as ``tcp://127.0.0.1:8786``, as ``dask scheduler`` prints it

    Raises
    ------
    InputError : ``distributed`` is not installed, nobody answers, or no worker is there.
    """
    try:
        import distributed
    except ImportError:
        raise InputError("a cluster needs the package distributed: pip install 'ecm-fast[cluster]'") from None
    connect: Any = distributed.Client
    comm: Any = distributed.comm
    try:
        comm.resolve_address(address)  # a client that fails in its making waits long to be deleted
        client: Any = connect(address, timeout=_PATIENCE, set_as_default=False)
    except Exception as error:  # what an address can be depends on the protocols that are installed
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise InputError(f"cluster {shown(address)}: no scheduler answers ({reason})") from None
    try:
        threads = sum(client.nthreads().values())
        if not threads:
            raise InputError(f"cluster {shown(address)}: has no workers; start some with: dask worker {address}")
        yield client.get_executor(retries=_RETRIES), threads
    finally:
        client.close()
