import xml.etree.ElementTree as ET

from posreal.network import Spring, parse, series


def test_hooks():
    network = parse("k=2.45e5 | (c + b)")
    assert network._repr_latex_().startswith("$Y = ")
    assert ET.fromstring(network._repr_svg_()).tag.endswith("svg")
    page = network._repr_html_()
    assert "<svg" in page
    assert "<td>245 kN/m</td>" in page


def test_a_large_network_is_shown_in_text():
    page = series(*[Spring(1)] * 61)._repr_html_()
    assert "<svg" not in page
    assert "[ k61 ]" in page
