"""One module for each system, run by the Python of that system's own environment.

Each has `main(spec, run_plant)` and imports only that system, the standard library and
`bench.echo.workload`, which needs only the standard library. The current folder is the run's.
"""
