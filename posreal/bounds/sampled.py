"""An expansion rounded to floats: what the searches for a certificate work on; their result is checked in balls."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from posreal.bounds.figure import Expansion
from posreal.bounds.interpolation_space import floats

Array = np.ndarray


@dataclass(frozen=True)
class Sampled:
    """Float midpoints of an :class:`Expansion`.

    Attributes
    ----------
    tau : (rows, m)
    O : (r, rows, m, m)
    W : (r, m, m)
    F : (m, m, m)
        F[j] is the operator whose first column is eⱼ.
    """

    tau: Array
    O: Array
    W: Array
    F: Array

    @classmethod
    def of(cls, expansion: Expansion) -> Sampled:
        """Round to the nearest floats."""
        m = expansion.space.size
        return cls(
            np.array([floats(t)[:, 0] for t in expansion.tau]),
            np.array([[floats(o) for o in loop] for loop in expansion.O]),
            np.array([floats(w) for w in expansion.W]),
            floats(expansion.space.basis).T.reshape(m, m, m),
        )
