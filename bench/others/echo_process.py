"""Entry point of an echo process: `echo_process.py MODULE measured|watched PART...`.

It runs in the environment of one system. That environment's libraries come first on the import path
and our folder last, so that no library installed beside ours is measured instead.
"""

import os
import signal
import sys
from importlib import import_module
from pathlib import Path

_LONGEST = 300  # [s]


def main() -> None:
    """Be the part that the command line names, in the folder where its run's processes meet."""
    from bench.echo.workload import be_plant, part_of
    from bench.others.arrivals import PLACE, be_watched_plant

    os.chdir(os.environ[PLACE])  # some systems start processes elsewhere
    module, how, *words = sys.argv[1:]
    part = part_of(words)
    sys.setswitchinterval(0.0005)  # [s], as in our processes
    signal.signal(signal.SIGTERM, lambda *_: os._exit(0))  # as good as killed: nothing to save
    signal.alarm(_LONGEST)  # if the bench is killed, nobody else ends this
    if part.role == "plant":
        # not by file descriptor 1, for some systems print there, and keep what is printed
        sys.stdout = open("said", "w", encoding="ascii")  # noqa: SIM115 # open to the end
    Path(f"{part.role.replace('/', '-')}.{os.getpid()}.pid").touch()
    side = import_module(module)
    side.main(part, be_plant if how == "measured" else be_watched_plant)


if __name__ == "__main__":
    # this folder's modules are not for import by their bare names: our root takes its place, until
    # it is settled where our own packages are
    sys.path[0] = str(Path(__file__).resolve().parents[2])
    for package in ("bench", sys.argv[1].partition(".")[0]):
        import_module(package)
    sys.path.append(sys.path.pop(0))
    main()
