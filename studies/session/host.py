"""On what a store was computed: the type of processor decides the last bits, so it is written down."""

from __future__ import annotations

import platform
from pathlib import Path
from typing import Any

from studies.session.installation import versions


def computer() -> dict[str, Any]:
    """Versions, processor and BLAS, as plain values."""
    return {"versions": versions(), "python": platform.python_version(), "processor": processor(), "blas": _blas()}


def processor() -> str:
    """The model of the processor, as the operating system names it."""
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


def _blas() -> str:
    import numpy as np

    config: Any = np.show_config(mode="dicts")
    blas = config.get("Build Dependencies", {}).get("blas", {})
    return f"{blas.get('name', 'unknown')} {blas.get('version', '')}".strip()
