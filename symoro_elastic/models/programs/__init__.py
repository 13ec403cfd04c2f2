"""The models that can be requested, and their programs in other forms."""
