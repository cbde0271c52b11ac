from posreal.network import parse
from posreal.network.table import rows, table


def test_the_table_says_each_value_twice():
    assert (
        table(parse("k=2.45e5 | (c=1/3 + b)"))
        == """\
name  kind     value       exact   unit
k     spring   245 kN/m    245000  N/m
c     damper   333 mN·s/m  1/3     N s/m
b     inerter                      kg"""
    )


def test_rows_are_data():
    row = rows(parse("{1-2: k=1, 2-0: b=1, 3-0: c=4, 1-2-3: n=1/2}"))[-1]
    assert (row.name, row.kind, row.value, row.exact, row.unit) == ("n", "lever", "0.5", "0.5", "")
