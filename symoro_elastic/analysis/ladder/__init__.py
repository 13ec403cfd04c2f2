"""Prediction of what springs, arithmetic, method and step cost on a motion, by one linear model along it."""
