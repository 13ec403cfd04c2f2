"""Models within tolerances: the search for terms to leave out, its results, and what is said of them."""
