"""The machine: what it is, and what it can do at most on one core."""

from __future__ import annotations

import importlib.metadata
import os
import platform
import time
from pathlib import Path
from typing import Any

import numpy as np
from threadpoolctl import threadpool_info

PACKAGES = ("numpy", "scipy", "numba", "simfield", "pycolmap", "gtsam")


def cpu_model() -> str:
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


def installed(package: str) -> str | None:
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return None


def description() -> dict[str, Any]:
    blas = next(library for library in threadpool_info() if library["user_api"] == "blas")
    return {
        "cpu": cpu_model(),
        "cores": os.cpu_count(),
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        "blas": f"{blas['internal_api']} {blas['version']}, kernels {blas.get('architecture')}",
        "packages": {package: installed(package) for package in PACKAGES},
        "load_average": [round(v, 2) for v in os.getloadavg()] if hasattr(os, "getloadavg") else None,
    }


def dgemm_gflops(size: int = 1000, repetitions: int = 15) -> list[float]:
    """GFLOP/s of double precision matrix products on one core, one number a repetition."""
    random = np.random.default_rng(0)
    a, b = random.standard_normal((size, size)), random.standard_normal((size, size))
    out = np.empty((size, size))
    np.matmul(a, b, out=out)
    rates = []
    for _ in range(repetitions):
        begin = time.perf_counter()
        np.matmul(a, b, out=out)
        rates.append(2.0 * size**3 / (time.perf_counter() - begin) / 1e9)
    return rates
