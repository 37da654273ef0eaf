"""The tables of the papers, as printed: CSV files whose first lines name the source, and a reader for each."""

from __future__ import annotations

from importlib.resources import files

import numpy as np
import pandas as pd

from simfield.block import Floats


def source(name: str) -> str:
    """The source of a table, as the comment lines at the head of its file give it."""
    lines = (files(__package__) / f"{name}.csv").read_text(encoding="utf-8").splitlines()
    return " ".join(line.lstrip("# ") for line in lines if line.startswith("#"))


def mauelshagen_table1() -> pd.DataFrame:
    """Table 1 of Mauelshagen 1980, 18 rows: 3 models x 3 camera combinations x without and with auxiliary points."""
    return _read("mauelshagen-1980-table1")


def mauelshagen_table2(*, aux_points: bool) -> Floats:
    """Table 2 of Mauelshagen 1980: the correlation matrix (14, 14) of b1 .. b14, symmetric, unit diagonal."""
    table = _read(f"mauelshagen-1980-table2-{'with' if aux_points else 'without'}-aux")
    upper = np.triu(table.iloc[:, 1:].to_numpy(float, na_value=0.0) / 100.0, 1)
    return np.asarray(upper + upper.T + np.eye(len(upper)))


def ziemann_el_hakim() -> pd.DataFrame:
    """The results of Ziemann & El-Hakim 1982: rms of the ground residuals at image scale, um; NaN is not readable."""
    return _read("ziemann-el-hakim-1982")


def _read(name: str) -> pd.DataFrame:
    with (files(__package__) / f"{name}.csv").open(encoding="utf-8") as file:
        return pd.read_csv(file, comment="#", skip_blank_lines=True)
