"""Machines drawn: a figure in space, its projection as SVG or PNG, and a page on which the machine moves."""
