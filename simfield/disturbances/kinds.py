"""Values that come in several kinds, told apart in a file by their `kind`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from typing import TYPE_CHECKING, Annotated, Any, Union

if TYPE_CHECKING:
    from pydantic import GetCoreSchemaHandler


class OneOf:
    """As in Annotated[Effect, OneOf(A, B)]: a file can give an A or a B here. Until a file is read, pydantic is not
    imported.
    """

    def __init__(self, *types: type[Any]) -> None:
        self.types = types

    def __get_pydantic_core_schema__(self, source: object, handler: GetCoreSchemaHandler) -> Any:
        from pydantic import Field

        union: Any = Union[self.types]  # noqa: UP007  # a union made at run time
        choice: Any = Annotated[union, Field(discriminator="kind")]
        return handler.generate_schema(choice)


def by_kind(types: Sequence[type[Any]]) -> dict[str, type[Any]]:
    """The dataclasses by the default of their field `kind`."""
    return {str(f.default): t for t in types for f in fields(t) if f.name == "kind"}
