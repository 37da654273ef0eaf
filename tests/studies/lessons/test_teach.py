"""The command: without the extra, on a port that is taken, and what the index lists."""

import socket
import subprocess
import sys

import pytest
from click.testing import CliRunner

from studies.commands import teach as cli_teach
from studies.commands.program import main
from studies.lessons.lesson import LESSONS
from studies.lessons.serving.server import index_page

HEAVY = ("marimo", "numpy", "matplotlib", "starlette", "uvicorn")


def test_without_the_extra_one_line_says_what_to_install(monkeypatch):
    monkeypatch.setattr(cli_teach, "find_spec", lambda name: None)
    done = CliRunner().invoke(main, ["teach"])
    assert done.exit_code == 2
    assert done.stderr.splitlines()[-1] == "Error: the lessons need marimo: pip install 'simfield[teach]'"


def test_a_port_that_is_taken_is_a_failure():
    pytest.importorskip("marimo")
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        done = CliRunner().invoke(main, ["teach", "--no-browser", "--port", str(other.getsockname()[1])])
    assert done.exit_code == 1
    assert "cannot be taken" in done.stderr


def test_the_help_imports_nothing_heavy():
    code = "from studies.commands import main; main(['teach', '-h'], standalone_mode=False)"
    code = f"import sys; {code}; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    assert "127.0.0.1" in done.stdout
    assert not set(HEAVY) & set(done.stdout.splitlines()[-1].split())


def test_the_index_lists_every_lesson():
    page = index_page()
    for lesson in LESSONS:
        assert f'<a href="{lesson.id}/">{lesson.question}</a>' in page
    assert "://" not in page
