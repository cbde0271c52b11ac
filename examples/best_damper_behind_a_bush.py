"""How much better can the vertical ride of a railway vehicle become?

    minimise    J1z(T), the r.m.s. acceleration over the trailing bogie
    over        positive-real admittances of order n, behind a bush of 5 MN/m, beside the airspring [Jiang2012]

Orders 1 and 2 are synthesised, realised as networks, and measured again from the networks. The first order gives a
damper in series with an inerter (layout S5); the second gains another two points.
"""

from __future__ import annotations

import posreal as pr
from posreal.study.strut import mounted, realised


def main() -> dict[str, float]:
    """J1z(T) in %g: airspring only, and with the network of each order."""
    problem = pr.problem("vertical-comfort")
    figures = {"airspring only": pr.evaluate(problem, None).objective.value}
    warm: list[pr.Rational] = []
    for order in (1, 2):
        design = pr.synthesise(problem, order, warm=warm)
        assert design.device is not None
        warm.append(design.device)
        built, realisation = realised(design)
        figures[f"order {order}"] = built.objective.value
        print(f"order {order}: {built.objective}, {len(realisation.network)} elements by {realisation.method}")
        print(pr.diagram(mounted(problem, realisation.network)))
        print()
    return figures


if __name__ == "__main__":
    print(main())
