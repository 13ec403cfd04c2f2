"""Benchmarks: speed, operations, growth. Not tests: pytest does not collect them, and each is one command.

    python -m tests.benchmarks.speed     time a call against Pinocchio C++, CasADi-generated C and MuJoCo
    python -m tests.benchmarks.compilers    calls by every compiler that is installed, at -O2 and -O3
    python -m tests.benchmarks.derivatives    the same for the derivatives of the models, with operations
    python -m tests.benchmarks.closed_chains    closed chains against Pinocchio C++: time, error, operations
    python -m tests.benchmarks.numpy_calls    the numpy code against the same lines on plain arrays
    python -m tests.benchmarks.counts    operations, and instructions by callgrind, against published figures
    python -m tests.benchmarks.robots urdf    robots of two packages against Pinocchio: errors, operations
    python -m tests.benchmarks.robots mjcf    robots of three packages against MuJoCo: errors
    python -m tests.benchmarks.optimum    terms left out against a bound on what any selection leaves
    python -m tests.benchmarks.growth    time to generate and to compile against the number of joints

All take `--json FILE`; `speed --picture FILE` draws the ratios. Needs gcc (clang too, where there is one) and
`pip install -e '.[benchmarks]'`. Peers get the same machine and the same states, and must give the same numbers
first. Contestants then take turns in many short rounds, so a busy machine slows all of them; what is told is the
median of the ratios within a round. Compiled code is kept in build/benchmarks.
"""
