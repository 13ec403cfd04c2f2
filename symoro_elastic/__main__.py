"""`python -m symoro_elastic`."""

from symoro_elastic.cli import main

if __name__ == "__main__":
    main()
