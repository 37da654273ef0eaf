"""Where results come from: what was run, on what, for how long."""

from __future__ import annotations

import os
import platform
import subprocess
from collections.abc import Mapping
from typing import Any

from studies.session.installation import home, versions


def provenance(command: str, parameters: Mapping[str, Any], duration_s: float) -> dict[str, Any]:
    """Version, commit, parameters, package versions, platform and duration, as plain types for JSON."""
    packages = versions()
    return {
        "command": command,
        "simfield": packages.pop("simfield"),
        "commit": commit(),
        "parameters": dict(parameters),
        "python": platform.python_version(),
        "packages": packages,
        "platform": {"system": platform.system(), "machine": platform.machine(), "processors": os.cpu_count()},
        "duration_s": round(duration_s, 1),
    }


def commit() -> str | None:
    """The commit of the checkout that simfield runs from, "+changes" if files differ; None outside of a checkout."""
    if not (home() / ".git").exists():
        return None
    try:
        head = _git("rev-parse", "HEAD")
        packages = ("simfield", "adjust", "studies")
        return head + ("+changes" if _git("status", "--porcelain", "--", *packages) else "")
    except (OSError, subprocess.CalledProcessError):
        return None


def _git(*arguments: str) -> str:
    done = subprocess.run(["git", *arguments], cwd=home(), capture_output=True, text=True, check=True, timeout=30)
    return done.stdout.strip()
