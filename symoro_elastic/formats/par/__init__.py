"""The .par files of SYMORO."""
