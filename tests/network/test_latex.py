import pytest
from hypothesis import given

from posreal.network import parse
from posreal.network.latex import formula, latex, symbol
from tests.strategies import networks


def test_a_picture():
    text = latex(parse("ke=2e5 + b"), ("body_1", "bogie"), document=True)
    assert r"to[spring, l={$k_{\mathrm{e}}$\ $200\,\mathrm{kN/m}$}]" in text
    assert r"to[inerter, l={$b$}]" in text
    assert r"{body\_1}" in text
    assert text.startswith(r"\documentclass")
    assert text.count(r"\begin") == text.count(r"\end") == 2


@given(networks(8))
def test_braces_and_elements_balance(network):
    text = latex(network)
    assert text.count("{") == text.count("}")
    counts = network.counts
    assert [text.count(f"to[{kind}") for kind in ("spring", "damper", "inerter")] == list(counts[:3])
    assert formula(network).count("{") == formula(network).count("}")


@pytest.mark.parametrize(
    ("text", "tex"),
    [
        ("k | c | b", r"Y = \frac{k}{s} + c + b\,s"),
        ("k1 | (c + b)", r"Y = \frac{k_{1}}{s} + \cfrac{1}{\cfrac{1}{c} + \cfrac{1}{b\,s}}"),
        ("{1-2: k, 2-0: c}", r"Y = Y_{\mathrm{graph}}(k, c)"),
    ],
)
def test_formula(text, tex):
    assert formula(parse(text)) == tex


def test_symbols():
    assert [symbol(name) for name in ("k", "k12", "ce")] == ["k", "k_{12}", r"c_{\mathrm{e}}"]
