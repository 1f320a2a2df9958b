"""`tests/peers/run dynamics`: every golden document of the dynamics, made again and compared; --write replaces them.

What: makes the documents with the engines, compares engine with engine and committed with fresh, prints one table.
Why: one command that answers "are the golden numbers right, and are they still what the engines say?".
How: each module has FILE, document(table) and compare_with_golden(fresh, committed, table). Exit status 1 when a bound
is exceeded or a golden file is missing.
"""

import importlib
import sys

import golden

MODULES = ["multibody", "appendage_fe", "planar_tank"]


def main(arguments):
    is_write = arguments == ["--write"]
    table = golden.Table()
    is_complete = True
    for name in MODULES:
        if not (golden.HERE / f"{name}.py").exists():
            continue
        module = importlib.import_module(name)
        fresh = module.document(table)
        if is_write:
            golden.write(module.FILE, fresh)
        committed = golden.read(module.FILE)
        if committed is None:
            is_complete = False
            print(f"tests/golden/{module.FILE} is missing; `tests/peers/run dynamics --write` makes it")
        else:
            module.compare_with_golden(fresh, committed, table)
            if committed["generator_sha256"] != fresh["generator_sha256"]:
                print(f"note: tests/golden/{module.FILE} was made by an earlier version of its script")
    table.show()
    return 0 if is_complete and table.holds() else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
