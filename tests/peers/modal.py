"""Modal identification beside pyOMA_2 and sdypy-EMA, on the same records in turn, each with one thread.

Errors are relative to the truth of the simulated record (for the frequency responses: to the mean of all tools); times are CPU
times, so that what else the machine does has no part in them. A pair is one line: theirs, ours, and the ratio of times.
"""
import json
import logging
import os
import pathlib
import subprocess
import sys
import tempfile
import time

os.environ["TQDM_DISABLE"] = "1"  # bars of others between the lines of the table

import numpy as np
from scipy.signal import lfilter

ROOT = pathlib.Path(__file__).resolve().parents[2]
OURS = ROOT / "target/release/examples/subspace"
RESPONSES = ROOT / "target/release/examples/responses"
BLOCK_ROWS = 30
REPEATS = 3


def ambient(channels, samples, seed):
    """Twelve modes driven by white noise, 100 Hz, sensor noise 20 dB below."""
    rng = np.random.default_rng(seed)
    rate = 100.0
    frequency = np.linspace(1.3, 23.0, 12) * (1 + 0.03 * rng.standard_normal(12))
    damping = rng.uniform(0.005, 0.02, 12)
    out = np.zeros((samples, channels))
    for f, zeta in zip(frequency, damping):
        w = 2 * np.pi * f / rate
        r = np.exp(-zeta * w)
        q = lfilter([1], [1, -2 * r * np.cos(w * np.sqrt(1 - zeta**2)), r * r], rng.standard_normal(samples + 4000))[4000:]
        out += np.outer(q / q.std(), rng.standard_normal(channels))
    out += 0.1 * out.std() * rng.standard_normal(out.shape)
    return out, rate, np.c_[frequency, damping]


def errors(poles, truth):
    """Median relative error of frequency and damping [%] of the poles nearest to the truth, and how many lie within 2 %."""
    poles = np.asarray([p for p in poles if p[1] > 0])
    f, z, found = [], [], 0
    for tf, tz in truth:
        k = np.argmin(np.abs(poles[:, 0] - tf) + 10 * np.abs(poles[:, 1] - tz))
        near = abs(poles[k, 0] / tf - 1)
        found += near < 0.02
        f.append(100 * near)
        z.append(100 * abs(poles[k, 1] / tz - 1))
    return np.median(f), np.median(z), found


def peer_subspace(y, rate, order, method):
    from pyoma2.functions import ssi

    begin = time.process_time()
    hankel, _ = ssi.build_hank(Y=y.T, Yref=y.T, br=BLOCK_ROWS, method=method)
    observability, a, c, *_ = ssi.SSI_fast(hankel, BLOCK_ROWS, order, step=1)
    poles = ssi.SSI_poles(observability, a, c, order, 1 / rate, step=1, HC=False)
    seconds = time.process_time() - begin
    frequency, damping = poles[0][:, -1], poles[1][:, -1]
    keep = np.isfinite(frequency)
    return np.c_[frequency[keep], damping[keep]], seconds


def our_subspace(path, channels, rate, order, method):
    arguments = [str(OURS), str(path), str(channels), str(rate), str(BLOCK_ROWS), str(order), "data" if method == "dat" else "cov"]
    said = json.loads(subprocess.run(arguments, check=True, capture_output=True, text=True).stdout)
    return np.asarray(said["poles"]), said


def subspace_pairs():
    failures = 0
    print(f"{'record':<34}{'tool':<22}{'CPU s':>8}{'median f %':>12}{'median zeta %':>15}{'found':>7}")
    for channels, samples, order, methods in [(10, 100_000, 60, ("cov", "dat")), (30, 100_000, 100, ("cov",))]:
        y, rate, truth = ambient(channels, samples, 7)
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "record.f64"
            y.astype("<f8").tofile(path)
            for method in methods:
                theirs, ours = [], []
                for _ in range(REPEATS if channels == 10 and method == "cov" else 1):
                    poles, seconds = peer_subspace(y, rate, order, method)
                    theirs.append(seconds)
                    mine, said = our_subspace(path, channels, rate, order, method)
                    ours.append(said["total_s"])
                what = f"{channels} ch x {samples}, br {BLOCK_ROWS}, order {order}"
                for tool, found, seconds in [(f"pyOMA_2 SSI {method}", poles, theirs), (f"obsid ssi-{method}", mine, ours)]:
                    f, z, count = errors(found, truth)
                    print(f"{what:<34}{tool:<22}{min(seconds):>8.3f}{f:>12.4f}{z:>15.2f}{count:>7d}")
                print(f"{'':<34}{'ratio':<22}{min(theirs) / min(ours):>8.1f}   memory of ours {said['memory_kb'] / 1024:.0f} MB, "
                      f"gram {said['gram_s']:.3f} s, factor {said['factor_s']:.3f} s, poles {said['poles_s']:.3f} s, update {said['update_us']:.2f} us")
                limit = {("cov", 10): 4.0, ("dat", 10): 35.0}.get((method, channels))
                if limit and min(theirs) / min(ours) < limit:
                    print(f"  below the demanded ratio {limit}")
                    failures += 1
    return failures


def response_pairs(folder):
    """sdypy-EMA and ours on frequency responses of one structure."""
    files = sorted(pathlib.Path(folder).glob("*.csv"))
    if not files:
        print(f"no frequency responses in {folder}: skipped")
        return 0
    from sdypy import EMA

    data = [np.loadtxt(file, delimiter=",", skiprows=1) for file in files]
    frequency = data[0][:, 0]
    responses = np.asarray([d[:, 1] + 1j * d[:, 2] for d in data])
    begin = time.process_time()
    model = EMA.Model(frf=responses, freq=frequency, lower=10, upper=1000, pol_order_high=30)
    model.get_poles(method="lscf", show_progress=False)
    theirs_s = time.process_time() - begin
    said = subprocess.run([str(RESPONSES), "12", *map(str, files)], check=True, capture_output=True, text=True).stdout
    line = next(line for line in said.splitlines() if line.startswith("12/16:"))
    words = line.replace("(", "").replace("%)", "").split()[1:]
    ours_s, ours = float(words[0]), np.asarray(words[2:], dtype=float).reshape(-1, 2)
    peer_f, peer_z = np.asarray(model.pole_freq[-1]), np.asarray(model.pole_xi[-1])
    print(f"\n{'frequency responses':<22}{'LSCF of sdypy-EMA, order 30':>32}{'RFP of obsid, 12/16':>28}{'difference':>24}")
    failures = 0
    for f, zeta in ours:
        k = int(np.argmin(np.abs(peer_f - f)))
        apart_mhz, apart_percent = 1e3 * (f - peer_f[k]), 100 * (zeta / (100 * peer_z[k]) - 1)
        print(f"{'':<22}{peer_f[k]:>18.4f} Hz {100 * peer_z[k]:>8.4f} %{f:>15.4f} Hz {zeta:>8.4f} %{apart_mhz:>12.2f} mHz{apart_percent:>8.1f} %")
        failures += abs(apart_mhz) > 10 or abs(apart_percent) > 10
    print(f"{'CPU s':<22}{theirs_s:>32.3f}{ours_s:>28.3f}   (ratio {theirs_s / ours_s:.1f}; one fit of each, all orders up to 30 of theirs)")
    return failures


if __name__ == "__main__":
    logging.disable(logging.INFO)
    recordings = sys.argv[1] if len(sys.argv) > 1 else str(ROOT.parent / "shared/recordings")
    sys.exit(1 if subspace_pairs() + response_pairs(pathlib.Path(recordings) / "free_beam_frf") else 0)
