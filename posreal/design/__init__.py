"""What is wanted, and the searches for it: problems, layouts and their best values, synthesis."""

from posreal.design.bound import Bound
from posreal.design.constraint import Constraint
from posreal.design.device import evaluate, read_design
from posreal.design.layout import Layout, layout, layouts
from posreal.design.mounting import Mounting
from posreal.design.named import limited, over_points, problem, problems
from posreal.design.optimise import optimise
from posreal.design.problem import Problem
from posreal.design.result import Design, metrics_to_dict
from posreal.design.search import Search
from posreal.design.synthesise import synthesise
from posreal.design.user_problem import problem_from_plant

__all__ = [
    "Bound",
    "Constraint",
    "Design",
    "Layout",
    "Mounting",
    "Problem",
    "Search",
    "evaluate",
    "layout",
    "layouts",
    "limited",
    "metrics_to_dict",
    "optimise",
    "over_points",
    "problem",
    "problem_from_plant",
    "problems",
    "read_design",
    "synthesise",
]
