"""How normal equations are made and factorised: what the readable and the compiled arithmetic both can do."""

from __future__ import annotations

from typing import Any, Protocol

from adjust.observations import Observations
from simfield.block import Floats


class Arithmetic(Protocol):
    """adjust.normals.normals.Plain or adjust.normals.normals_compiled.Compiled."""

    @property
    def observations(self) -> Observations:
        """What is adjusted."""

    def at(self, x: Floats) -> Any:
        """The normal equations at x, with `finite`, `vpv`, `depth`, their `diagonal`, and `damped(share)`."""

    def gradient(self, x: Floats) -> Any:
        """As `at`, but only the gradients, `vpv` and `depth` are needed."""

    def factorise(self, normals: Any, condition_least: float = ...) -> Any:
        """Raises SingularError where the reciprocal condition is less."""
