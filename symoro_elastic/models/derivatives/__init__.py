"""Derivatives of models."""
