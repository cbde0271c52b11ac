"""What the campaign draws: devices whose text and admittance are built side by side, vehicles, plants of one's own.

Every draw is a function of a seed alone, so that a failing one can be repeated by the command that it prints.
"""

from __future__ import annotations

import math
import shlex
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np

from tests.fuzz import independent
from tests.fuzz.independent import Device, element, parallel, polynomial, series

Node = tuple  # (letter, value text) or ("|" or "+", node, node, …)
VEHICLES = {"lateral": "plan-view", "vertical": "side-view", "quarter": "quarter-car"}
DEFAULTS = {
    "plan-view": independent.PLAN_VIEW,
    "side-view": independent.SIDE_VIEW,
    "quarter-car": independent.QUARTER_CAR,
}
LATERAL = ("lateral-comfort", "lateral-comfort-primary", "lateral-gauging", "lateral-gauging-primary")


@dataclass(frozen=True)
class Draw:
    """A device in a problem: what is typed, and what it means exactly."""

    problem: str
    text: str
    device: Device
    overrides: Mapping[str, float] = field(default_factory=dict)
    options: tuple[str, ...] = ()

    @property
    def vehicle_name(self) -> str:
        return VEHICLES[self.problem.split("-")[0]]

    @property
    def vehicle(self) -> dict[str, float]:
        found = {**DEFAULTS[self.vehicle_name], **self.overrides}
        if "--stiffness" in self.options:
            found["k"] = float(self.options[self.options.index("--stiffness") + 1])
        return found

    @property
    def toml(self) -> str:
        return "\n".join([f"[{self.vehicle_name}]", *(f"{name} = {value!r}" for name, value in self.overrides.items())])

    def words(self, vehicle_file: str) -> list[str]:
        vehicle = ["--vehicle", vehicle_file] if self.overrides else []
        return ["evaluate", self.problem, self.text, *self.options, *vehicle, "--json"]

    @property
    def command(self) -> str:
        """One line that repeats it."""
        line = shlex.join(["posreal", *self.words("v.toml")])
        return f"printf {shlex.quote(self.toml)} > v.toml; {line}" if self.overrides else line


# --- devices -------------------------------------------------------------------------------------------------


def number(value: float) -> str:
    return f"{value:.6g}"


def log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    return float(10 ** rng.uniform(math.log10(low), math.log10(high)))


def leaf(letter: str, value: float) -> Node:
    return (letter, number(value))


def text_of(node: Node, inside: str = "") -> str:
    if node[0] in "kcb":
        return f"{node[0]}={node[1]}"
    joined = f" {node[0]} ".join(text_of(child, node[0]) for child in node[1:])
    return f"({joined})" if inside else joined


def device_of(node: Node) -> Device:
    if node[0] in "kcb":
        return element(node[0], Fraction(node[1]))
    return {"|": parallel, "+": series}[node[0]](*map(device_of, node[1:]))


def resonator(rng: np.random.Generator, omega: float, Q: float, b: float) -> Node:
    """One of three ways to a resonance of the admittance or the impedance at `omega` with factor Q."""
    k = b * omega**2
    match int(rng.integers(3)):
        case 0:
            return ("+", ("|", leaf("k", k), leaf("c", k / (omega * Q))), leaf("b", b))
        case 1:
            return ("+", leaf("k", k), leaf("b", b), leaf("c", Q * b * omega))
        case _:
            return (
                "+",
                leaf("c", log_uniform(rng, 1e2, 1e5)),
                ("|", leaf("k", k), leaf("b", b), leaf("c", b * omega / Q)),
            )


def resonance(rng: np.random.Generator, problem: str) -> Node:
    """Q from 1 to 1e6 anywhere in 0.1–100 Hz."""
    omega, Q = 2 * math.pi * log_uniform(rng, 0.1, 100), log_uniform(rng, 1, 1e6)
    return ("|", leaf("c", log_uniform(rng, 1e2, 3e4)), resonator(rng, omega, Q, log_uniform(rng, 1, 1e4)))


def side_branch(rng: np.random.Generator, problem: str) -> Node:
    """A tuned branch of next to no weight."""
    omega, Q = 2 * math.pi * log_uniform(rng, 0.1, 100), log_uniform(rng, 10, 1e6)
    return ("|", leaf("c", log_uniform(rng, 1e2, 3e4)), resonator(rng, omega, Q, log_uniform(rng, 1e-7, 1e-1)))


def lone_resonance(rng: np.random.Generator, problem: str) -> Node:
    """Nothing in the device but a sharp resonance: the loop's damping is the vehicle's own, where it has any."""
    omega, Q = 2 * math.pi * log_uniform(rng, 0.3, 30), log_uniform(rng, 1e2, 1e6)
    return resonator(rng, omega, Q, log_uniform(rng, 10, 1e4))


def tuned(rng: np.random.Generator, problem: str) -> Node:
    """A sharp absorber of some weight near the body's modes, beside a damper: the loop's own resonance is as sharp."""
    omega, Q = 2 * math.pi * log_uniform(rng, 0.5, 8), log_uniform(rng, 1e3, 1e6)
    b = log_uniform(rng, 0.002, 0.1) * (250 if problem == "quarter-car" else 2e4)
    branch = ("+", leaf("k", b * omega**2), leaf("b", b), leaf("c", Q * b * omega))
    return ("|", leaf("c", log_uniform(rng, 3e2, 3e3) * (1 if problem == "quarter-car" else 10)), branch)


_RANGES = {"k": (1e4, 1e7), "c": (1e2, 1e6), "b": (1.0, 1e4)}


def tree(rng: np.random.Generator, size: int, ranges: Mapping[str, tuple[float, float]], joint: str = "") -> Node:
    if size == 1:
        letter = "kcb"[int(rng.integers(3))]
        return leaf(letter, log_uniform(rng, *ranges[letter]))
    joint = {"|": "+", "+": "|"}.get(joint) or "|+"[int(rng.integers(2))]
    left = int(rng.integers(1, size))
    return (joint, tree(rng, left, ranges, joint), tree(rng, size - left, ranges, joint))


def network(rng: np.random.Generator, problem: str) -> Node:
    """One to six elements of plausible size; undamped ones among them."""
    return tree(rng, int(rng.integers(1, 7)), _RANGES)


def extreme(rng: np.random.Generator, problem: str) -> Node:
    """Up to four elements of 1e-9 to 1e9."""
    return tree(rng, int(rng.integers(1, 5)), dict.fromkeys("kcb", (1e-9, 1e9)))


def nearly_undamped(rng: np.random.Generator, problem: str) -> Node:
    """A damper that locks the port or hardly touches it."""
    c = log_uniform(rng, 1e7, 1e11) if rng.integers(2) else log_uniform(rng, 1e-8, 1e-1)
    return leaf("c", c) if rng.integers(3) else ("|", leaf("c", c), leaf("b", log_uniform(rng, 1, 1e3)))


def undamped(rng: np.random.Generator, problem: str) -> Node:
    """Springs and inerters only: a quarter-car must be refused; the rail vehicles have damping of their own."""
    letters = {"k": _RANGES["k"], "c": _RANGES["b"], "b": _RANGES["b"]}

    def without_dampers(node: Node) -> Node:
        return (
            "b" if node[0] == "c" else node[0],
            *(c if isinstance(c, str) else without_dampers(c) for c in node[1:]),
        )

    return without_dampers(tree(rng, int(rng.integers(1, 5)), letters))


def plant_pole(rng: np.random.Generator, problem: str) -> Node:
    """A branch with the pole of the unsprung mass on its primary suspension, exactly, beside a damper."""
    share = Fraction(int(rng.integers(1, 200)), 1000)
    if problem == "quarter-car":
        mass, k, c = 35, 150_000, None
    elif problem == "vertical-comfort":
        mass, k, c = 2500, 4 * 4_935_000, 4 * 50_740
    else:
        mass, k, c = 3477, 4 * 4_710_000, 4 * 12_000
    spring: Node = ("k", number_exact(k * share))
    if c is not None:
        spring = ("|", spring, ("c", number_exact(c * share)))
    return ("|", leaf("c", log_uniform(rng, 1e2, 3e4)), ("+", spring, ("b", number_exact(mass * share))))


def number_exact(value: Fraction) -> str:
    """As a decimal; the denominators here are powers of ten."""
    return format(float(value), ".12g")


def biquadratic(rng: np.random.Generator, problem: str) -> tuple[str, Device]:
    """c (s² + 2ζωs + ω²)/(s² + 2ζ'ω's + ω'²), positive real by (ω − ω')² ≤ 4 ζζ'ωω': a pole and a zero close by, a
    common factor typed out, or a minimum function (equality)."""
    c = number(log_uniform(rng, 1e2, 1e5))
    omega = Fraction(number(2 * math.pi * log_uniform(rng, 0.1, 100)))
    match int(rng.integers(3)):
        case 0:  # close by
            zeta = log_uniform(rng, 1e-6, 0.1)
            ratio = Fraction(number(log_uniform(rng, 0.1, 10)))
            shift = Fraction(repr(round(1 + rng.uniform(-1, 1) * 1.9 * zeta * math.sqrt(ratio) / (1 + zeta), 15)))
            top = [omega**2, 2 * Fraction(number(zeta)) * omega, Fraction(1)]
            bottom = [(shift * omega) ** 2, 2 * Fraction(number(zeta)) * ratio * shift * omega, Fraction(1)]
        case 1:  # a common factor, itself lightly damped or on the axis
            zeta = Fraction(number(log_uniform(rng, 1e-9, 1))) * int(rng.integers(2))
            factor = [omega**2, 2 * zeta * omega, Fraction(1)]
            top, bottom = (_product(factor, [Fraction(number(x)), Fraction(1)]) for x in (30 * rng.random(), 30.5))
        case _:  # (s² + ws + w²)/(s² + ws + 4w²) touches Re = 0
            top, bottom = [omega**2, omega, Fraction(1)], [4 * omega**2, omega, Fraction(1)]
    text = f"{c}*({_algebra(top)})/({_algebra(bottom)})"
    device = independent.fraction(polynomial([Fraction(c) * x for x in top]), polynomial(bottom))
    return text, device


def _product(p: list[Fraction], q: list[Fraction]) -> list[Fraction]:
    found = [Fraction(0)] * (len(p) + len(q) - 1)
    for i, x in enumerate(p):
        for j, y in enumerate(q):
            found[i + j] += x * y
    return found


def _algebra(coefficients: list[Fraction]) -> str:
    return " + ".join(f"{c}*s^{i}" if i else f"{c}" for i, c in enumerate(coefficients) if c)


KINDS: dict[str, Callable[[np.random.Generator, str], Node | tuple[str, Device]]] = {
    kind.__name__: kind
    for kind in (
        resonance,
        side_branch,
        lone_resonance,
        network,
        extreme,
        nearly_undamped,
        undamped,
        plant_pole,
        biquadratic,
        tuned,
    )
}


# --- vehicles ------------------------------------------------------------------------------------------------


def tram(rng: np.random.Generator) -> dict[str, float]:
    return {"mw": 700.0, "Iw": 400.0, "mg": 1800.0, "Ig": 1500.0, "mv": 8000.0, "r0": 0.33, "lwx": 0.9, "Kpy": 6e6}


def soft_car(rng: np.random.Generator) -> dict[str, float]:
    return {"Ksy": number_in(rng, 5e4, 1.5e5), "Csy": 8e3, "mv": 22000.0}


def low_conicity(rng: np.random.Generator) -> dict[str, float]:
    return {"conicity": number_in(rng, 0.02, 0.25)}


def slow(rng: np.random.Generator) -> dict[str, float]:
    return {"V": number_in(rng, 5, 50)}


def any_side(rng: np.random.Generator) -> dict[str, float]:
    names = [n for n in independent.SIDE_VIEW if n not in ("g", "Kaz")]
    found = {n: number_in(rng, *(np.array([0.5, 2]) * independent.SIDE_VIEW[n])) for n in rng.choice(names, 4)}
    return found | ({"Kaz": number_in(rng, 1e4, 3e5)} if rng.integers(2) else {})


def any_quarter(rng: np.random.Generator) -> dict[str, float]:
    names = list(independent.QUARTER_CAR)
    return {n: number_in(rng, *(np.array([0.2, 5]) * independent.QUARTER_CAR[n])) for n in rng.choice(names, 3)}


def number_in(rng: np.random.Generator, low: float, high: float) -> float:
    return float(number(log_uniform(rng, low, high)))


OTHERS = {
    "plan-view": (tram, soft_car, low_conicity, slow),
    "side-view": (any_side, slow),
    "quarter-car": (any_quarter,),
}


# --- a draw --------------------------------------------------------------------------------------------------


def draw(kind: str, group: str, seed: int) -> Draw:
    """The draw of a kind of device in a group of problems (lateral, vertical, quarter-car) that a seed stands for."""
    rng = np.random.default_rng([list(KINDS).index(kind), list(VEHICLES).index(group.split("-")[0]), seed])
    problem = {"lateral": LATERAL[int(rng.integers(4))], "vertical": "vertical-comfort"}.get(group, "quarter-car")
    made = KINDS[kind](rng, problem)
    text, device = (
        made
        if len(made) == 2 and isinstance(made[1], tuple) and made[0] not in "|+"
        else (text_of(made), device_of(made))
    )
    options: list[str] = []
    if problem == "vertical-comfort":
        options += ["--position", "LMT"[int(rng.integers(3))]]
        options += ["--objective", "whole-band"] if rng.integers(2) else []
    if problem == "quarter-car":
        objectives = ("J1", "J3", "gain_acceleration", "gain_tyre_force", "J1 + 0.001*J3", "J3 + gain_acceleration")
        options += ["--objective", objectives[int(rng.integers(len(objectives)))]]
        options += ["--stiffness", number(log_uniform(rng, 5e3, 2e5))] if rng.integers(2) else []
    name = VEHICLES[problem.split("-")[0]]
    overrides: dict[str, float] = {}
    if kind != "plant_pole" and rng.random() < 0.3:
        other = OTHERS[name][int(rng.integers(len(OTHERS[name])))]
        overrides = {n: float(x) for n, x in other(rng).items()}
    return Draw(problem, text, device, overrides, tuple(options))


# --- plants of one's own -------------------------------------------------------------------------------------


@dataclass(frozen=True)
class OwnPlant:
    """Matrices with the first inputs white (processes as groups of input numbers), the last the device's force; the
    last output the velocity of its port."""

    matrices: tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]
    groups: tuple[tuple[int, ...], ...]
    delays: Mapping[int, float]
    densities: tuple[float, ...]
    device: str
    exact: Device


def companion(numerator: np.ndarray, denominator: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """State space of a proper transfer function (descending powers) as textbooks and python-control write it."""
    a = np.asarray(denominator, dtype=float) / denominator[0]
    c = np.concatenate([np.zeros(len(a) - len(numerator)), numerator]) / denominator[0]
    n = len(a) - 1
    A = np.zeros((n, n))
    A[0] = -a[1:]
    A[1:, :-1] = np.eye(n - 1)
    B = np.zeros((n, 1))
    B[0, 0] = 1.0
    return A, B, (c[1:] - c[0] * a[1:])[None, :], float(c[0])


def weighting(steeper: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Wk of ISO 2631-1, numerator and denominator, descending; `steeper` more low passes at 100 Hz."""
    w = {i: 2 * math.pi * f for i, f in ((1, 0.4), (2, 100.0), (3, 12.5), (4, 12.5), (5, 2.37), (6, 3.35))}
    high = np.array([1.0, 0, 0]), np.array([1.0, math.sqrt(2) * w[1], w[1] ** 2])
    low = np.array([w[2] ** 2]), np.array([1.0, math.sqrt(2) * w[2], w[2] ** 2])
    turn = np.array([w[4] ** 2 / w[3], w[4] ** 2]), np.array([1.0, w[4] / 0.63, w[4] ** 2])
    step = (
        np.array([1.0, w[5] / 0.91, w[5] ** 2]) * (w[6] / w[5]) ** 2,
        np.array([1.0, w[6] / 0.91, w[6] ** 2]),
    )
    top, bottom = np.array([1.0]), np.array([1.0])
    for numerator, denominator in (high, low, turn, step, *[low] * steeper):
        top, bottom = np.polymul(top, numerator), np.polymul(bottom, denominator)
    # the step's gain is 1 at high frequency times (w5/w6)² at low: ISO's factor makes it (f6/f5)²·(f5/f6)² = 1 at ω → 0
    return top / (w[6] / w[5]) ** 2, bottom


def weighted(plant: tuple[np.ndarray, ...], output: int, steeper: int = 0) -> tuple[np.ndarray, ...]:
    """The plant with one output replaced by its weighted self, the filter in companion form behind it."""
    A, B, C, D = plant
    Af, Bf, Cf, Df = companion(*weighting(steeper))
    n, m = len(A), len(Af)
    both = np.block([[A, np.zeros((n, m))], [Bf @ C[output : output + 1], Af]])
    inputs = np.vstack([B, Bf @ D[output : output + 1]])
    outputs, through = np.hstack([C, np.zeros((len(C), m))]), D.copy()
    outputs[output] = np.concatenate([Df * C[output], Cf[0]])
    through[output] = Df * D[output]
    return both, inputs, outputs, through


def quarter_plant(ms: float, mu: float, k: float, kt: float) -> tuple[np.ndarray, ...]:
    """States (zs − zu, zu − zr, żs, żu); inputs road velocity, device force; outputs z̈s, stroke, żs − żu."""
    A = np.array([[0, 0, 1, -1], [0, 0, 0, 1], [-k / ms, 0, 0, 0], [k / mu, -kt / mu, 0, 0]])
    B = np.array([[0, 0], [-1, 0], [0, -1 / ms], [0, 1 / mu]])
    C = np.array([A[2], [1, 0, 0, 0], [0, 0, 1, -1]])
    return A, B, C, np.array([[0, -1 / ms], [0, 0], [0, 0]])


def chain(rng: np.random.Generator, masses: int) -> tuple[np.ndarray, ...]:
    """Masses on springs and dampers in a row: white forces on the first and last, a device from ground to the first.

    Outputs: displacement of the last, velocity of the first, and the port's velocity.
    """
    m, k, zeta = (np.array([log_uniform(rng, *r) for _ in range(masses)]) for r in ((1, 1e4), (1e2, 1e7), (1e-4, 0.3)))
    link = np.eye(masses) - np.eye(masses, k=-1)
    K = link.T @ np.diag(k) @ link
    damping = link.T @ np.diag(zeta * np.sqrt(k * m)) @ link
    A = np.block([[np.zeros((masses, masses)), np.eye(masses)], [-K / m[:, None], -damping / m[:, None]]])
    B = np.zeros((2 * masses, 3))
    B[masses, 0], B[-1, 1], B[masses, 2] = 1 / m[0], 1 / m[-1], -1 / m[0]
    C = np.zeros((3, 2 * masses))
    C[0, masses - 1] = C[1, masses] = C[2, masses] = 1.0
    return A, B, C, np.zeros((3, 3))


def transformed(plant: tuple[np.ndarray, ...], how: str, rng: np.random.Generator) -> tuple[np.ndarray, ...]:
    """The plant in other coordinates x = T x'."""
    from scipy.linalg import matrix_balance

    A, B, C, D = plant
    n = len(A)
    if how == "raw":
        return plant
    if how == "balanced":
        T = matrix_balance(A, permute=False)[1]
    elif how == "powers of two":
        T = np.diag(2.0 ** rng.integers(-40, 41, n))
    elif how == "rotated":  # of the balanced plant, so that the transformation itself keeps its digits
        T = matrix_balance(A, permute=False)[1] @ np.linalg.qr(rng.normal(size=(n, n)))[0]
    else:
        T = matrix_balance(A, permute=False)[1] @ rng.normal(size=(n, n))
    return np.linalg.solve(T, A @ T), np.linalg.solve(T, B), C @ T, D


WAYS = ("raw", "balanced", "powers of two", "rotated", "mixed")


def own_plant(seed: int) -> OwnPlant:
    """A weighted quarter-car (one road, or one of two channels), or a chain with two forces or a late one."""
    rng = np.random.default_rng([99, seed])
    if rng.integers(2):
        values = (log_uniform(rng, 100, 1e3), log_uniform(rng, 10, 100), log_uniform(rng, 5e3, 1e5), 150e3)
        plant = weighted(quarter_plant(*values), 0, int(rng.integers(3)))
        A, B, C, D = plant
        if rng.integers(2):  # a share of the road comes once more, late
            B, D = (np.hstack([x[:, :1], float(number(rng.uniform(0.1, 1))) * x[:, :1], x[:, 1:]]) for x in (B, D))
            groups: tuple[tuple[int, ...], ...] = ((0, 1),)
            delays = {1: float(number(log_uniform(rng, 1e-3, 1)))}
        else:
            groups, delays = ((0,),), {}
        plant = A, B, C, D
        device = resonance(rng, "") if rng.integers(2) else leaf("c", log_uniform(rng, 50, 1e4))
        densities = (4 * math.pi * 25 * 5e-7,)
    else:
        plant = chain(rng, int(rng.integers(1, 5)))
        late = bool(rng.integers(2))
        groups, delays = (((0, 1),), {1: float(number(log_uniform(rng, 1e-3, 1)))}) if late else (((0,), (1,)), {})
        densities = (1.0,) if late else (1.0, float(number(log_uniform(rng, 0.01, 100))))
        device = resonance(rng, "")
    plant = transformed(plant, WAYS[int(rng.integers(len(WAYS)))], rng)
    return OwnPlant(plant, groups, delays, densities, text_of(device), device_of(device))  # type: ignore[arg-type]
