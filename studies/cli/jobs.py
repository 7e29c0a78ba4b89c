"""Commands that may take long: where they compute, kept parts, and how they are stopped."""

from __future__ import annotations

import shlex
import signal
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from missions.files.writing import OutputError
from studies.cli.options import EXIT_FAILED, Work
from studies.cli.start import let_dask_in
from studies.cli.telling import progress_of, tell_error
from studies.engine.chunk_store import ChunkStore
from studies.engine.run import Job, run
from studies.engine.workers import WorkersUnavailableError
from studies.output.gridded import Gridded
from studies.signals import Stopped
from studies.study import Study


@contextmanager
def completed(study: Study, options: Work) -> Iterator[Gridded]:
    """Compute a study; inside the context its result is to be written and printed.

    After it the parts go. A signal ends the command with 128 plus its number and the way to go on;
    so does a disk that fills up, as an error. Where cells failed, standard error says so before and
    after the result, and the command ends with exit code 1; where all of them did there is no
    result.
    """
    job = study.job
    folder = None if options.out_file is None else parts_folder(options.out_file)
    if options.work_dir is not None:
        folder = Path(options.work_dir)
    with ExitStack() as stack:
        store = None
        if folder is not None:
            opened = ChunkStore(folder).opened(job.size_bytes, len(job.chunks))
            store = stack.enter_context(opened)
        try:
            if options.scheduler is not None:
                let_dask_in()
            pool = study.pool(
                options.workers, options.scheduler, lambda text: tell_error(f"solar-uav: {text}")
            )
            with progress_of(study.unit) as progress:
                outcome = run(job, pool, store, progress)
            trouble = study.trouble(outcome)
            if trouble is not None:
                tell_error(f"solar-uav: {trouble}")
            if len(outcome.failures) == len(study.cells):
                sys.exit(EXIT_FAILED)
            yield study.gridded(outcome)
        except KeyboardInterrupt as stopped:
            number = stopped.signum if isinstance(stopped, Stopped) else signal.SIGINT
            tell_error(f"stopped; {_kept(job, store)}")
            sys.exit(128 + number)
        except (OutputError, WorkersUnavailableError) as error:
            tell_error(f"solar-uav: {error}; {_kept(job, store)}")
            sys.exit(EXIT_FAILED)
        if store is not None and not options.keep_parts and not outcome.failures:
            store.remove_parts(job.keys())
    if trouble is not None:
        tell_error(f"solar-uav: the result is not complete: {trouble}")
        sys.exit(EXIT_FAILED)


def _kept(job: Job, store: ChunkStore | None) -> str:
    if store is None:
        return "nothing is kept (--out or --work would keep what is finished)"
    keys = job.keys()
    count = sum(store.path(key).is_file() for key in keys)
    command = shlex.join(["solar-uav", *sys.argv[1:]])
    return f"{count} of {len(job.chunks)} chunks are kept in {store.folder}; to go on:\n  {command}"


def parts_folder(target: str) -> Path | None:
    """Return the folder for the parts of a result file; None for a device or a pipe."""
    path = Path(target)
    return path.with_name(f"{path.name}.parts") if path.is_file() or not path.exists() else None
