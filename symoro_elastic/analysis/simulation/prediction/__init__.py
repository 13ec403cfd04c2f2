"""Linear prediction of what springs, arithmetic, method and step cost on a motion."""
