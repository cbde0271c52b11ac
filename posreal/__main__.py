"""``python -m posreal``."""

from posreal.cli import main

main()
