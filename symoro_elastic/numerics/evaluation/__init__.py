"""Programs and models in numbers: values of parameters, states, and motions whose loops are closed."""
