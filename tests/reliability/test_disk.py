"""The disk refuses the n-th operation, for every n: a clear error, a valid store, and a retry that works."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from studies.commands.program import main
from studies.run.verification import verify
from tests.studies.small_study import TEXT, contents, run_here, study

SMALL = (("max = 96", "max = 40"), ("[3.0, 6.0]", "[3.0]"), ('["none", "optical"]', '["none"]'))


class FailingDisk:
    """os.write, os.fsync, os.replace and os.open for writing, of which the n-th call fails."""

    def __init__(self, patch: pytest.MonkeyPatch, fails_at: int, number: int) -> None:
        self.calls, self.fails_at, self.number = 0, fails_at, number
        for name in ("write", "fsync", "replace", "mkdir"):
            patch.setattr(os, name, self.counted(getattr(os, name)))

    def counted(self, real: Callable[..., Any]) -> Callable[..., Any]:
        def call(*arguments: Any, **named: Any) -> Any:
            self.calls += 1
            if self.calls == self.fails_at:
                raise OSError(self.number, os.strerror(self.number))
            return real(*arguments, **named)

        return call


@pytest.fixture(autouse=True)
def _no_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures are matplotlib's to write; everything else goes through whole_files."""
    monkeypatch.setattr("studies.pages.study_report._draw", lambda *arguments: [])


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    folder: Path = tmp_path_factory.mktemp("undisturbed")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("studies.pages.study_report._draw", lambda *arguments: [])
        run_here(folder, study(TEXT, *SMALL))
    return contents(folder)


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EIO, errno.EACCES])
def test_the_nth_write_fails_for_every_n(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, undisturbed: dict[str, bytes], number: int
) -> None:
    fails_at, step = 1, 1 if number == errno.ENOSPC else 5
    while True:
        folder = tmp_path / str(fails_at)
        with pytest.MonkeyPatch.context() as patch:
            disk = FailingDisk(patch, fails_at, number)
            try:
                run_here(folder, study(TEXT, *SMALL))
            except OSError as error:
                assert error.errno == number  # noqa: PT017
            else:
                break
        assert disk.calls >= fails_at
        if (folder / "manifest.json").exists() and (folder / "study.toml").exists():
            assert all("is missing" in line for line in verify(folder, lambda line: None))
        run_here(folder, study(TEXT, *SMALL))
        assert contents(folder) == undisturbed
        fails_at += step
    assert fails_at > 20


def test_the_command_says_so_in_a_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "small.toml").write_text(TEXT, encoding="utf-8")
    (tmp_path / "file").write_text("", encoding="utf-8")
    done = CliRunner().invoke(main, ["run", str(tmp_path / "small.toml"), "--out", str(tmp_path / "file" / "x")])
    assert done.exit_code == 1
    assert "File exists" in done.output
    assert "Traceback" not in done.output
