"""Golden documents: writing, reading and comparing them.

What: one JSON layout for all golden files, every number with the digits that give the same double back; the greatest
relative difference of two documents; and the side-by-side table that the peers print.
Why: `cargo test` reads the committed numbers and needs no Python; whoever doubts them makes them again.
How: a document names the script that made it by the SHA-256 of its sources, the engines by version, and the seed.

The relative difference of two arrays is max|a - b| / max(max|a|, max|b|): relative to the array's greatest entry, so
that an entry which is zero but for rounding does not count as wholly different.
"""

import hashlib
import json
import pathlib

import numpy as np

HERE = pathlib.Path(__file__).parent
GOLDEN = HERE.parent / "golden"
LINE_WIDTH = 120


def source_sha256(names):
    """SHA-256 over the named sources of this directory, one after the other."""
    digest = hashlib.sha256()
    for name in names:
        digest.update((HERE / name).read_bytes())
    return digest.hexdigest()


def plain(value):
    """Numpy to lists of Python numbers; minus zero becomes zero."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray):
        return plain(value.ravel().tolist())
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, (bool, int, str)) or value is None:
        return value
    return float(value) + 0.0


def layout(value, indent=0):
    """JSON text: what fits a line stays on it, arrays of numbers are one line, everything else is opened."""
    flat = json.dumps(value)
    is_row = isinstance(value, list) and not any(isinstance(item, (list, dict)) for item in value)
    if len(flat) + indent <= LINE_WIDTH or is_row or not isinstance(value, (list, dict)):
        return flat
    pad = " " * (indent + 1)
    if isinstance(value, dict):
        rows = [f"{pad}{json.dumps(key)}: {layout(item, indent + 1)}" for key, item in value.items()]
        return "{\n" + ",\n".join(rows) + "\n" + " " * indent + "}"
    rows = [pad + layout(item, indent + 1) for item in value]
    return "[\n" + ",\n".join(rows) + "\n" + " " * indent + "]"


def write(name, document):
    path = GOLDEN / name
    path.write_text(layout(plain(document)) + "\n")
    print(f"wrote tests/golden/{name}: {path.stat().st_size} bytes")


def read(name):
    path = GOLDEN / name
    return json.loads(path.read_text()) if path.exists() else None


def relative_difference(a, b):
    a, b = np.asarray(a, float).ravel(), np.asarray(b, float).ravel()
    if a.shape != b.shape:
        return float("inf")
    if a.size == 0:
        return 0.0
    scale = max(np.abs(a).max(), np.abs(b).max())
    return 0.0 if scale == 0.0 else float(np.abs(a - b).max() / scale)


class Table:
    """Rows (case, engine A, engine B, quantity, greatest relative difference, bound); remembers whether all hold."""

    def __init__(self):
        self.worst = {}

    def add(self, case, engine_a, engine_b, quantity, difference, bound):
        key = (case, engine_a, engine_b, quantity)
        before = self.worst.get(key, (0.0, bound))[0]
        # A NaN must not be lost in max().
        self.worst[key] = (difference if not difference <= before else before, bound)

    def compare(self, case, engine_a, engine_b, quantity, a, b, bound):
        self.add(case, engine_a, engine_b, quantity, relative_difference(a, b), bound)

    def holds(self):
        return all(difference <= bound for difference, bound in self.worst.values())

    def show(self):
        head = ("case", "engine A", "engine B", "quantity", "greatest rel. diff.", "bound")
        rows = [
            (*key, f"{difference:.1e}", f"{bound:.0e}" + ("" if difference <= bound else "  EXCEEDED"))
            for key, (difference, bound) in self.worst.items()
        ]
        widths = [max(len(row[i]) for row in [head, *rows]) for i in range(len(head))]
        for row in [head, tuple("-" * width for width in widths), *rows]:
            print("  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip())
