"""The paper's equations, written once for any scalar: numbers, arrays, symbols, a finite field."""
