"""posreal: optimal passive suspension devices, and how to build them from springs, dampers and inerters.

>>> import posreal as pr
>>> problem = pr.problem("vertical-comfort")
>>> s5 = pr.optimise(problem, pr.layout("S5"))
>>> ideal = pr.synthesise(problem, order=2)            # doctest: +SKIP
>>> network = pr.realise(ideal.device).network         # doctest: +SKIP
>>> print(pr.diagram(s5.network))
  body ─[ k ]─[ c ]─[ b ]─ bogie
  k = 5 MN/m       c = 18 kN·s/m    b = 4110 kg
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from posreal.admittance import PortHamiltonian, Rational, StateSpace, Verdict, check, state_space
    from posreal.bounds.compute import bound
    from posreal.bounds.file import load_bound
    from posreal.bounds.result import Bound
    from posreal.errors import BadDevice, BadInput, Infeasible, NotPositiveReal, PosrealError
    from posreal.metric import Measured, Metric
    from posreal.network import (
        Damper,
        Graph,
        Inerter,
        Lever,
        Network,
        Parallel,
        Series,
        Spring,
        bridge,
        nodal_admittance,
        parse,
    )
    from posreal.network.diagram import diagram
    from posreal.network.latex import latex
    from posreal.network.picture import save_picture
    from posreal.network.spice import spice
    from posreal.network.table import table
    from posreal.optimisation.evaluate import evaluate
    from posreal.optimisation.layout_values import optimise
    from posreal.plant.plant import Plant
    from posreal.realisation import Limits, Realisation, Repair, nearest_positive_real, realise, realise_all
    from posreal.specification.constraint import Constraint
    from posreal.specification.design import Design
    from posreal.specification.from_plant import problem_from_plant
    from posreal.specification.layout import Layout, layout, layouts
    from posreal.specification.named import problem, problems
    from posreal.specification.problem import Problem
    from posreal.study.compare import Comparison, compare
    from posreal.study.pareto import Pareto, pareto
    from posreal.study.preferred import Preferred, preferred
    from posreal.study.recommendation import Recommendation, design
    from posreal.study.reproduce import Reproduction, reproduce
    from posreal.study.simulate import simulate
    from posreal.study.simulate_result import Simulation
    from posreal.study.sweep import Sweep, sweep
    from posreal.study.tolerance import tolerance
    from posreal.study.tolerance_result import Tolerance
    from posreal.synthesis.in_cvxpy import step_in_cvxpy
    from posreal.synthesis.synthesise import synthesise
    from posreal.topology.result import Search
    from posreal.topology.search import search
    from posreal.vehicle import PlanView, QuarterCar, SideView, Vehicle
    from posreal.vehicle.flexible_body import FlexibleBody, MeasuredMode
    from posreal.vehicle.track import Track
    from posreal.vehicle.weighting import Weighting

__version__ = "0.1.0"

_ROOMS = {  # where each name is, loaded when it is first asked for: a command needs few of them
    "posreal.admittance": (
        "PortHamiltonian",
        "Rational",
        "StateSpace",
        "Verdict",
        "check",
        "state_space",
    ),
    "posreal.bounds.compute": ("bound",),
    "posreal.bounds.file": ("load_bound",),
    "posreal.bounds.result": ("Bound",),
    "posreal.errors": (
        "BadDevice",
        "BadInput",
        "Infeasible",
        "NotPositiveReal",
        "PosrealError",
    ),
    "posreal.metric": (
        "Measured",
        "Metric",
    ),
    "posreal.network": (
        "Damper",
        "Graph",
        "Inerter",
        "Lever",
        "Network",
        "Parallel",
        "Series",
        "Spring",
        "bridge",
        "nodal_admittance",
        "parse",
    ),
    "posreal.network.diagram": ("diagram",),
    "posreal.network.latex": ("latex",),
    "posreal.network.picture": ("save_picture",),
    "posreal.network.spice": ("spice",),
    "posreal.network.table": ("table",),
    "posreal.optimisation.evaluate": ("evaluate",),
    "posreal.optimisation.layout_values": ("optimise",),
    "posreal.plant.plant": ("Plant",),
    "posreal.realisation": (
        "Limits",
        "Realisation",
        "Recommendation",
        "Repair",
        "nearest_positive_real",
        "realise",
        "realise_all",
    ),
    "posreal.specification.constraint": ("Constraint",),
    "posreal.specification.design": ("Design",),
    "posreal.specification.from_plant": ("problem_from_plant",),
    "posreal.specification.layout": (
        "Layout",
        "layout",
        "layouts",
    ),
    "posreal.specification.named": (
        "problem",
        "problems",
    ),
    "posreal.specification.problem": ("Problem",),
    "posreal.study.compare": (
        "Comparison",
        "compare",
    ),
    "posreal.study.pareto": (
        "Pareto",
        "pareto",
    ),
    "posreal.study.preferred": (
        "Preferred",
        "preferred",
    ),
    "posreal.study.recommendation": (
        "Recommendation",
        "design",
    ),
    "posreal.study.reproduce": (
        "Reproduction",
        "reproduce",
    ),
    "posreal.study.simulate": ("simulate",),
    "posreal.study.simulate_result": ("Simulation",),
    "posreal.study.sweep": (
        "Sweep",
        "sweep",
    ),
    "posreal.study.tolerance": ("tolerance",),
    "posreal.study.tolerance_result": ("Tolerance",),
    "posreal.synthesis.in_cvxpy": ("step_in_cvxpy",),
    "posreal.synthesis.synthesise": ("synthesise",),
    "posreal.topology.result": ("Search",),
    "posreal.topology.search": ("search",),
    "posreal.vehicle": (
        "PlanView",
        "QuarterCar",
        "SideView",
        "Vehicle",
    ),
    "posreal.vehicle.flexible_body": (
        "FlexibleBody",
        "MeasuredMode",
    ),
    "posreal.vehicle.track": ("Track",),
    "posreal.vehicle.weighting": ("Weighting",),
}
_HOME = {name: room for room, names in _ROOMS.items() for name in names}

__all__ = [
    "BadDevice",
    "BadInput",
    "Bound",
    "Comparison",
    "Constraint",
    "Damper",
    "Design",
    "FlexibleBody",
    "Graph",
    "Inerter",
    "Infeasible",
    "Layout",
    "Lever",
    "Limits",
    "Measured",
    "MeasuredMode",
    "Metric",
    "Network",
    "NotPositiveReal",
    "Parallel",
    "Pareto",
    "PlanView",
    "Plant",
    "PortHamiltonian",
    "PosrealError",
    "Preferred",
    "Problem",
    "QuarterCar",
    "Rational",
    "Realisation",
    "Recommendation",
    "Repair",
    "Reproduction",
    "Search",
    "Series",
    "SideView",
    "Simulation",
    "Spring",
    "StateSpace",
    "Sweep",
    "Tolerance",
    "Track",
    "Vehicle",
    "Verdict",
    "Weighting",
    "__version__",
    "bound",
    "bridge",
    "check",
    "compare",
    "design",
    "diagram",
    "evaluate",
    "latex",
    "layout",
    "layouts",
    "load_bound",
    "nearest_positive_real",
    "nodal_admittance",
    "optimise",
    "pareto",
    "parse",
    "preferred",
    "problem",
    "problem_from_plant",
    "problems",
    "realise",
    "realise_all",
    "reproduce",
    "save_picture",
    "search",
    "simulate",
    "spice",
    "state_space",
    "step_in_cvxpy",
    "sweep",
    "synthesise",
    "table",
    "tolerance",
]


def __getattr__(name: str) -> Any:
    """A public name on its first use [PEP 562]."""
    if name not in _HOME:
        raise AttributeError(f"module 'posreal' has no attribute {name!r}")
    value = globals()[name] = getattr(import_module(_HOME[name]), name)
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
