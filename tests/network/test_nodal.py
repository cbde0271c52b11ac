import flint
import pytest
from flint import arb
from hypothesis import given, settings
from hypothesis import strategies as st

from posreal.errors import BadDevice
from posreal.network import nodal_admittance, nodal_value, parse
from tests.strategies import lever_networks, networks, trees


@given(networks(5))
def test_a_long_value_lies_on_the_exact_function(network):
    value = nodal_value(network, 1.75j, digits=60)
    with flint.ctx.workprec(200):
        for part, exact in zip((value.real, value.imag), nodal_admittance(network).exact_response("7/4"), strict=True):
            error = abs(part - arb(exact.numerator) / exact.denominator)
            assert error < arb(10) ** -40 * abs(value)


@given(lever_networks(2), st.sampled_from(((1, 0), (2, 3))))
def test_a_network_with_a_lever_is_passive(network, at):
    """Y is real on the real axis, and Re Y ≥ 0 to the right of the imaginary one."""
    assert float(nodal_value(network, complex(*at)).real) > 0


@settings(max_examples=8)
@given(trees(25, least=25))
def test_twenty_five_elements(network):
    assert nodal_admittance(network) == network.admittance()


def test_a_point_on_a_pole_is_named():
    with pytest.raises(BadDevice, match="move it a little"):
        nodal_value(parse("k=1 | b=1"), 1j)
