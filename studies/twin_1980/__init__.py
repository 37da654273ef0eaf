"""A twin of 1969: worlds in which the table of Mauelshagen 1980 happens. They could have been; nobody says they were."""

from studies.twin_1980.story import reproduce_twin

__all__ = ["reproduce_twin"]
