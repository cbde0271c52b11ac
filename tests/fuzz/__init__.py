"""A campaign of drawn inputs: every printed number against an independent program, every message against the rule.

``make fuzz`` runs it (some minutes); the default suite and ``make test-long`` leave it out, but for the tests of the
independent program itself. Each draw is a function of its seed alone, and each failure prints the command that repeats
it.

    python -m pytest -m fuzz tests/fuzz --fuzz-seed 7 --fuzz-size 100

draws from another place (0 by default), and ten times as many of each kind (10 by default); so do POSREAL_FUZZ_SEED and
POSREAL_FUZZ_SIZE with ``make fuzz``.

independent      the figures of the three vehicles and of plants of one's own, sharing no line with posreal
draws            devices of ten kinds, vehicles, plants in several coordinates
runner           commands at some milliseconds each, with limits on time and memory
test_numbers     the JSON of ``evaluate``, the table beside it, refusals
test_messages    bad numbers, texts and files of the known kinds; command lines drawn by spoiling good ones
test_independent figures known before either program
"""
