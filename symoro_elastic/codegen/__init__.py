"""Programs as text: C, numpy, LaTeX; this room sees programs and never machines."""
