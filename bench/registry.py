"""The benches by name."""

from importlib import import_module

from bench.bench import Bench, BenchError

BENCHES = {
    "loop": "bench.loop:LoopBench",
    "others": "bench.others.comparison:OthersBench",
    "start": "bench.start:StartBench",
    "scale": "bench.scale:ScaleBench",
    "decide": "bench.decide:DecideBench",
    "gap": "bench.gap:GapBench",
}
"""`module:Class` by name."""


def bench(name: str) -> Bench:
    """Return the bench of that name.

    Raises:
        BenchError: There is none; the message lists the valid names.
    """
    if name not in BENCHES:
        raise BenchError(f"there is no bench {name!r}; valid are {', '.join(BENCHES)}, all")
    module, _, kind = BENCHES[name].partition(":")
    made: Bench = getattr(import_module(module), kind)()
    return made
