"""Numerical quality of models: test states, references in many digits, verification."""
