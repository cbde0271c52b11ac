"""A model of the user's own as data: what a page of TOML says, in the words that it is said with.

    coordinates    each with its mass or inertia
    connections    springs, dampers, inerters, any admittance in s, each on a linear form of coordinates and inputs;
                   with `on`, its force acts on another form than it feels (creep, followers)
    places         where devices go: the forms of their ports, and what stands beside and behind
    inputs         displacements of the ground under a wheel, forces; white or coloured, several late of one another
    outputs        displacement, velocity, acceleration of a form, force of a connection or of a place
    metrics        figures of the outputs
    parameters     numbers with a name, which every other text may use

Texts are expressions (:mod:`.expression`), so that a parameter changes everything that hangs on it.
"""

from __future__ import annotations

from dataclasses import dataclass

LATE = "follows"
QUANTITIES = ("velocity", "acceleration", "displacement", "force")
OUTPUTS = ("displacement", "velocity", "acceleration", "force")
METRICS = ("rms", "gain", "peak", "damping_ratio", "sum")


@dataclass(frozen=True)
class Named:
    """A parameter."""

    name: str
    value: float
    unit: str = "1"
    meaning: str = ""
    source: str = "the file"


@dataclass(frozen=True)
class Connection:
    """What stands between the ends of a linear form and pushes back, on that form or on another."""

    name: str
    between: str
    on: str | None = None
    stiffness: str | None = None
    damping: str | None = None
    inertance: str | None = None
    admittance: str | None = None


@dataclass(frozen=True)
class Excitation:
    """An input: white, or white through a `filter` in s, of its own or `follows` another one after a `delay`."""

    name: str
    quantity: str
    on: str | None = None
    follows: str | None = None
    delay: str = "0"
    density: str = "1"
    filter: str | None = None


@dataclass(frozen=True)
class Signal:
    """An output: a `kind` of a linear form, or the force of the connection or place of that name."""

    name: str
    kind: str
    of: str
    unit: str = "1"


@dataclass(frozen=True)
class Opening:
    """A place, with the form of each of its ports, which hold copies of one device."""

    name: str
    ports: tuple[str, ...]
    beside: str | None = None
    behind: str | None = None
    static_spring: str | None = None
    bush: str | None = None
    default: str | None = None
    default_label: str = "default"
    terminals: tuple[str, str] = ("+", "-")
    carried: str = "0"


@dataclass(frozen=True)
class Judged:
    """A metric: a `kind` of an output (of several metrics, for a sum), `factor` of whose SI unit make its `unit`."""

    name: str
    kind: str
    output: str = ""
    unit: str = "1"
    factor: str = "1"
    to: str | None = None
    corners: tuple[tuple[float, float], ...] = ()
    parts: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True)
class Model:
    """A whole file."""

    name: str
    parameters: tuple[Named, ...]
    coordinates: tuple[tuple[str, str], ...]
    connections: tuple[Connection, ...]
    places: tuple[Opening, ...]
    inputs: tuple[Excitation, ...]
    outputs: tuple[Signal, ...]
    metrics: tuple[Judged, ...] = ()
