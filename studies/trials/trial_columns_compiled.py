"""The deviations of many trials at the points of a block, compiled: one pass over the estimates where numpy takes ten.

Sums run over the points of one trial in their order, so the bits of a trial do not depend on its neighbours.

Readable form: `studies.comparison.measures`. Agreement: `tests/agreement/test_compiled_twins.py`.
"""

from __future__ import annotations

import numba
import numpy as np

from simfield.numerics import machine_code

machine_code.install()


@numba.njit(cache=True, error_model="numpy")
def point_deviations(x, first, true, given, origin, free, check, t_sigma0, root, out):  # type: ignore[no-untyped-def]
    """Into out (7, t): 2-D and height rms at check points against the given coordinates; 2-D and height rms, mean
    height error and the shares of covered plan and height coordinates at free points against the truth.

    x (t, size): estimates, the points from column `first` on, reduced by origin (3) as true (n, 3) is and given (1 or
    t, n, 3) is not, m; free, check (n): points that are compared; t_sigma0 (t) times root (n, 3): half the intervals.
    NaN without points.
    """
    n = len(true)
    every = len(given) > 1
    for t in range(len(x)):
        g = t if every else 0
        checks, frees = 0.0, 0.0
        given_xy, given_z, true_xy, true_z, sum_z, inside_xy, inside_z = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for p in range(n):
            at = first + 3 * p
            if check[p]:
                dx = x[t, at] - (given[g, p, 0] - origin[0])
                dy = x[t, at + 1] - (given[g, p, 1] - origin[1])
                dz = x[t, at + 2] - (given[g, p, 2] - origin[2])
                given_xy += dx * dx + dy * dy
                given_z += dz * dz
                checks += 1.0
            if free[p]:
                ex, ey, ez = x[t, at] - true[p, 0], x[t, at + 1] - true[p, 1], x[t, at + 2] - true[p, 2]
                true_xy += ex * ex + ey * ey
                true_z += ez * ez
                sum_z += ez
                inside_xy += abs(ex) <= t_sigma0[t] * root[p, 0]
                inside_xy += abs(ey) <= t_sigma0[t] * root[p, 1]
                inside_z += abs(ez) <= t_sigma0[t] * root[p, 2]
                frees += 1.0
        out[0, t], out[1, t] = np.sqrt(given_xy / checks), np.sqrt(given_z / checks)
        out[2, t], out[3, t] = np.sqrt(true_xy / frees), np.sqrt(true_z / frees)
        out[4, t], out[5, t], out[6, t] = sum_z / frees, 0.5 * inside_xy / frees, inside_z / frees
