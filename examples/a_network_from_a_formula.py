"""From an admittance to springs, dampers and inerters, with proof.

Y(s) = (s² + s + 1)/(s² + s + 4) is positive real but only just: Re Y(jω) touches zero at ω = √2. With any less damping
in the denominator no passive network makes it, and the exact verdict says where it fails.
"""

from __future__ import annotations

import posreal as pr


def main() -> dict[str, float]:
    """Number of elements, residual of the proof, and the frequency at which a slightly smaller damping fails."""
    verdict = pr.check("(s^2 + s + 1)/(s^2 + s + 4)")
    print(verdict)
    realisation = pr.realise("(s^2 + s + 1)/(s^2 + s + 4)")
    print(pr.diagram(realisation.network))
    print(f"its admittance, recomputed from the graph: {pr.nodal_admittance(realisation.network)}")
    refused = pr.check("(s^2 + s + 1)/(s^2 + 0.999999999999*s + 4)")
    print(refused)
    return {
        "elements": len(realisation.network),
        "residual": realisation.residual,
        "touches": verdict.touches[0],
        "fails": float(refused.witness.omega),  # type: ignore[union-attr]
    }


if __name__ == "__main__":
    main()
