"""Every figure of [Jiang2012] that a test leans on, as printed: Tables 2, 3, 5, 6 and the text.

J.Z. Jiang, A.Z. Matamoros-Sanchez, R.M. Goodall, M.C. Smith, "Passive suspensions incorporating inerters for railway
vehicles", Vehicle System Dynamics 50 (sup1), 2012, 263-276. SI units unless named.
"""

from __future__ import annotations

from typing import NamedTuple


class Lateral(NamedTuple):
    """A row of Table 2 (figure: Macc, m/s²) or Table 3 (figure: Max(yv), mm)."""

    problem: str
    layout: str
    figure: float
    values: dict[str, float]
    vehicle: dict[str, float]


class Vertical(NamedTuple):
    """A row of Table 6: J1z(T) in %g and the improvements at L, M, T in per cent."""

    layout: str
    T: float
    improvements: tuple[float, float, float]
    values: dict[str, float]


TABLE2 = (
    Lateral("lateral-comfort", "S1", 0.2204, {"c": 2.0e4}, {}),
    Lateral("lateral-comfort", "S2", 0.2204, {"c": 2.01e4, "b": 2.0}, {}),
    Lateral("lateral-comfort", "S3", 0.2172, {"c": 2.1025e4, "b": 1.53e4}, {}),
    Lateral("lateral-comfort-primary", "S1", 0.1997, {"c": 1.61e4}, {"Kpy": 6.33e6, "Cpy": 5.24e3}),
    Lateral("lateral-comfort-primary", "S2", 0.1921, {"c": 1.51e4, "b": 256.0}, {"Kpy": 6.68e6, "Cpy": 5.4e3}),
    Lateral("lateral-comfort-primary", "S3", 0.1936, {"c": 1.69e4, "b": 9.74e3}, {"Kpy": 6.38e6, "Cpy": 5.26e3}),
)
TABLE3 = (
    Lateral("lateral-gauging", "S1", 77.1, {"k": 2.45e5, "c": 2e4}, {}),
    Lateral("lateral-gauging", "S3", 74.3, {"k": 2.61e5, "c": 2.1e4, "b": 1.37e4}, {}),
    Lateral("lateral-gauging-primary", "S1", 64.3, {"k": 2.94e5, "c": 1.84e4}, {"Kpy": 6.42e6, "Cpy": 5.27e3}),
    Lateral(
        "lateral-gauging-primary",
        "S3",
        61.6,
        {"k": 3.13e5, "c": 1.94e4, "b": 1.03e4},
        {"Kpy": 6.50e6, "Cpy": 5.33e3},
    ),
)
TABLE5 = {"J1z_L": 1.66, "J1z_M": 1.05, "J1z_T": 2.22}
TABLE6 = (
    Vertical("S4", 2.03, (-0.62, 6.71, 8.57), {"k": 5e6, "c": 11049.0, "b": 92.0}),
    Vertical("S5", 1.97, (-0.37, 4.62, 11.46), {"k": 5e6, "c": 17855.0, "b": 4138.0}),
    Vertical("S7", 2.01, (-1.16, 7.86, 9.69), {"k": 1.50e6, "c": 13932.0, "b": 165.0}),
)
LDMP_DEFAULT = 6.45  # per cent
MACC_DEFAULT = 0.2204
OVERALL_REDUCTION_FRONT = (4.0, 8.0)  # per cent
OVERALL_REDUCTION_REAR = (10.0, 14.0)
