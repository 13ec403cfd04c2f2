"""Speed against accuracy: every way to generate and compile a model, timed and measured side by side."""
