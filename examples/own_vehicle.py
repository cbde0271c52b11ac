"""A lateral suspension for a vehicle of one's own: heavier body, softer secondary spring.

    minimise    Macc over the values of layout S3, k | (c + b)
    subject to  the least damping ratio over 1 … 55 m/s no less than with this vehicle's conventional suspension

Parameters can be numbers in SI units or text with a unit; in a file they stand in a table [plan-view].
"""

from __future__ import annotations

import posreal as pr


def main() -> dict[str, float]:
    """Macc (m/s²) of the conventional suspension and of the best S3."""
    problem = pr.problem("lateral-comfort", vehicle={"mv": "20 t", "Ksy": "220 kN/m"})
    conventional = pr.evaluate(problem, None)
    best = pr.optimise(problem, pr.layout("S3"), starts=2, any_values=True)
    best.check()
    print(pr.diagram(best.network))
    print(f"{conventional.objective} → {best.objective}: {best.improvement():.2f} % better")
    return {"conventional": conventional.objective.value, "S3": best.objective.value}


if __name__ == "__main__":
    main()
