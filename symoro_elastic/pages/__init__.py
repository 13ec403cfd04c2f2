"""Tables, drawings and documents about a machine."""
