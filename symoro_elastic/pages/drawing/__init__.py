"""Drawings of machines: a figure in space, its projection as SVG or PNG, and a page with the moving machine."""
