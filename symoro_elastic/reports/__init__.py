"""Tables for the terminal, and documents with equations."""
