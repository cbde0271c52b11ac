import re
import xml.etree.ElementTree as ET

import pytest
from hypothesis import given, settings

from posreal.errors import BadInput
from posreal.network import parse
from posreal.network.picture import picture, save_picture
from tests.strategies import networks

STRUT = parse("k=1.41 MN/m | (c=57.8 kN s/m + b=312)")


@settings(max_examples=10)
@given(networks(10))
def test_any_network_has_a_picture(network):
    assert ET.fromstring(picture(network)).tag.endswith("svg")


def test_png_and_svg_by_the_ending(tmp_path):
    save_picture(STRUT, tmp_path / "a.png", terminals=("car", "wheel"))
    save_picture(STRUT, tmp_path / "a.svg")
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    assert re.search(rb"<svg", (tmp_path / "a.svg").read_bytes())


def test_what_cannot_be_made():
    with pytest.raises(BadInput, match="as 'gif'; give png or svg"):
        picture(STRUT, format="gif")


def test_drawing_leaves_no_figure_and_the_backend_behind():
    import matplotlib
    import matplotlib.pyplot as plt

    with matplotlib.rc_context({"backend": "svg"}):
        picture(STRUT, format="png")
        assert matplotlib.get_backend() == "svg"
    assert plt.get_fignums() == []
