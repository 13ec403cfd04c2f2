"""Machine files made to agree with vibration tests: tests and their files, estimation, verdicts."""
