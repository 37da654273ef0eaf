"""Similarity transformations of a whole block: the seven motions that no image can see."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from adjust.model.rotation import Flags, angles_of, rotation_derivatives, rotation_matrices
from simfield.block import Floats


@dataclass(frozen=True, eq=False)
class Similarity:
    """X -> shift + scale turn X, with a rotation matrix turn (3, 3)."""

    shift: Floats
    turn: Floats
    scale: float

    @classmethod
    def between(cls, points: Floats, targets: Floats, rigid: bool = False) -> Similarity:
        """The one that brings points (k, 3) nearest to targets (k, 3), in the sum of squares (Umeyama 1991).

        rigid: with a scale of 1.
        """
        middle, aim = points.mean(axis=0), targets.mean(axis=0)
        left, values, right = np.linalg.svd((targets - aim).T @ (points - middle))
        sign = np.array([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
        turn = (left * sign) @ right
        scale = 1.0 if rigid else float(values @ sign / np.sum((points - middle) ** 2))
        return cls(aim - scale * turn @ middle, turn, scale)

    def points(self, coordinates: Floats) -> Floats:
        """(n, 3)."""
        return np.asarray(self.shift + self.scale * coordinates @ self.turn.T)

    def exterior(self, exterior: Floats, renamed: Flags | None = None) -> Floats:
        """(m, 6): stations and angles of the images; angles stay within half a turn of what they were."""
        angles = angles_of(self.turn @ rotation_matrices(exterior[:, 3:], renamed), renamed)
        full = np.round((exterior[:, 3:] - angles) / (2.0 * np.pi)) * 2.0 * np.pi
        return np.hstack([self.points(exterior[:, :3]), angles + full])


def station_motions(exterior: Floats, pivot: Floats, renamed: Flags | None = None) -> Floats:
    """(m, 6, 7): the change of exterior orientations (m, 6) under small shifts, rotations and scale about `pivot`."""
    moves = np.zeros((len(exterior), 6, 7))
    moves[:, :3] = point_motions(exterior[:, :3], pivot)
    rotation, by_angle = rotation_derivatives(exterior[:, 3:], renamed)
    for axis in range(3):
        # the angles change so that dR = [axis]_x R
        turned = np.cross(np.eye(3)[axis], rotation, axisb=1, axisc=1)
        for image in range(len(exterior)):
            columns = by_angle[:, image].reshape(3, 9).T
            moves[image, 3:, 3 + axis] = np.linalg.lstsq(columns, turned[image].ravel(), rcond=None)[0]
    return moves


def point_motions(coordinates: Floats, pivot: Floats) -> Floats:
    """(n, 3, 7): the change of points (n, 3) under small shifts, rotations and scale about `pivot`."""
    position = coordinates - pivot
    moves = np.zeros((len(position), 3, 7))
    moves[:, :, :3] = np.eye(3)
    for axis in range(3):
        moves[:, :, 3 + axis] = np.cross(np.eye(3)[axis], position)
    moves[:, :, 6] = position
    return moves
