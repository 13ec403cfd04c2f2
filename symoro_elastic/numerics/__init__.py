"""What models are worth in numbers: test states, references in many digits, verification."""
