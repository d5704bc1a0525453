"""One module a system, run by the Python of that system's own environment.

Each has `main(part, be_plant)`. They import that system, the standard library and the traffic of
`bench.echo.load`, which needs no more: nothing else of ours is there. What a process finds in its
current folder is its run's.
"""
