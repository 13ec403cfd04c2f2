"""`python -m symoro_elastic.cli`."""

from symoro_elastic.cli import main

main()
