"""`python -m symoro_elastic`."""

from symoro_elastic.cli import main

main()
