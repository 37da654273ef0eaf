"""How commands fail: exit codes, and failures of studies in the words of a shell."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator

import click

LOCKED = 75


class Failure(click.ClickException):
    """The data or the computation failed: one line, exit 1."""

    exit_code = 1


class StoreFailure(click.ClickException):
    """The store is damaged or belongs to another study."""

    exit_code = 3


class Held(click.ClickException):
    """Another run holds the store."""

    exit_code = LOCKED


@contextlib.contextmanager
def exit_codes() -> Iterator[None]:
    """Failures of studies as the exit codes that a shell sees, each with its lines and no traceback."""
    from simfield.scenario import ScenarioError
    from studies.design import StudyError
    from studies.run import BackendError
    from studies.store import DamageError, LockedError, StoreError

    try:
        yield
    except (StudyError, ScenarioError) as error:
        raise click.UsageError(str(error)) from error
    except LockedError as error:
        raise Held(str(error)) from error
    except (StoreError, DamageError) as error:
        raise StoreFailure(str(error)) from error
    except BackendError as error:
        raise Failure(str(error)) from error
    except BrokenPipeError:
        raise
    except OSError as error:
        raise Failure(f"{error.filename or 'the store'}: {error.strerror or error}; what is whole is kept") from error
