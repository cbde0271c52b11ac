"""What stands at the end of every command's help: lines to copy."""

from __future__ import annotations

EXAMPLES: dict[str, tuple[str, ...]] = {
    "problems": ("posreal problems", "posreal problems --json"),
    "layouts": ("posreal layouts", "posreal layouts S7", "posreal layouts mine.toml"),
    "vehicle": ("posreal vehicle side-view", "posreal vehicle quarter-car --vehicle mine.toml"),
    "track": ("posreal track", "posreal track erri-low --speed 55", "posreal track china --plot china.png"),
    "design": (
        "posreal design vertical-comfort",
        "posreal design lateral-comfort --elements 3 --report lateral.html",
    ),
    "evaluate": (
        "posreal evaluate vertical-comfort default",
        "posreal evaluate lateral-comfort S3 c=2.1025e4 b=1.53e4",
        "posreal evaluate vertical-comfort default --weighting Wb --track erri-low --speed '200 km/h'",
        'posreal evaluate quarter-car "c=1500 | (k=20 kN/m + b=50)" --sweep V=10:40:4',
    ),
    "optimise": (
        "posreal optimise vertical-comfort S5 S7",
        "posreal optimise vertical-comfort S5 --limit deflection_rear=34 --vehicle mine.toml",
    ),
    "synthesise": (
        "posreal synthesise vertical-comfort --order 2",
        "posreal synthesise quarter-car --order 3 --objective J3 --write network.png",
    ),
    "realise": (
        'posreal realise "(s^2+s+1)/(s^2+s+4)"',
        'posreal realise "Z = (s+1)(s+3)/(s(s+2))" --method all',
        "posreal realise device.json --tolerance 0.02 --b-max 500 --write strut.cir",
    ),
    "check": (
        'posreal check "(s^2+s+1)/(s^2+0.999*s+4)"',
        'posreal check "(s^2+s+1)/(s^2+0.999*s+4)" --repair parallel',
    ),
    "search": (
        "posreal search vertical-comfort --elements 4",
        "posreal search quarter-car --elements 3 --at-most inerters=1 --plot front.png",
    ),
    "bound": ("posreal bound quarter-car --save proof.json", "posreal bound quarter-car --orders 1,2,4,8"),
    "check-bound": ("posreal check-bound proof.json",),
    "compare": ("posreal compare vertical-comfort --plot rows.png", "posreal compare quarter-car --orders 1,2,3"),
    "preferred": (
        "posreal preferred vertical-comfort S5 c=17965 b=4115 --series R20",
        'posreal preferred vertical-comfort "b=2741 + (c=14196 | k=83748)" --series mine.toml',
    ),
    "tolerance": ('posreal tolerance vertical-comfort "c=2e4 | b=300"',),
    "ranges": (
        "posreal ranges vertical-comfort > mine.toml",
        "posreal search vertical-comfort --elements 4 --ranges mine.toml",
    ),
    "simulate": ('posreal simulate vertical-comfort "c=2e4 | b=300" --friction 500 --stop 60',),
    "reproduce": ("posreal reproduce", "posreal reproduce --figures figures"),
}


def epilog(command: str) -> str | None:
    """The examples of a command, set line by line; None where there are none."""
    lines = EXAMPLES.get(command)
    return None if lines is None else "\n".join(["\b", "Examples:", *(f"  {line}" for line in lines)])
