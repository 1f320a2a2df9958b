"""PySINDy and SysIdentPy beside `obsid diagnose`, on the same real recordings: fitted on one part, free run on another.

Every tool sees the same fitting record and is asked on the same held-out record. Of the peers several settings are tried; the one with
the smallest rms in free run on the last 30 % of the fitting record (of several fitting records: on the last) is fitted again to all of it.
The settings are in `discrepancy_models.py`. Time is CPU time of all settings.
Cut recordings are written to a temporary folder, never beside the originals. Exit status 0 when all tools ran.
"""
import csv
import gzip
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time
import warnings

import numpy as np
from scipy.signal import savgol_filter

from discrepancy_models import narx_settings, sindy_settings

ROOT = pathlib.Path(__file__).resolve().parents[2]
RIGS = ROOT / "deploy/plants/rigs"
ASKED = {}
WHEEL_ON_S = [6.1, 59.3]  # of the documentation: the peers are told; the plant file gives obsid 6 and 53 s, uncertain by half a second


def read(path):
    """Header, and the rows as text with their numbers."""
    with (gzip.open if path.suffix == ".gz" else open)(path, "rt", newline="") as file:
        rows = list(csv.reader(file))
    return rows[0], rows[1:], np.asarray(rows[1:], dtype=float)


class Case:
    """One recording: files for obsid, arrays `(t, y, u)` for the peers."""

    def __init__(self, name, rig, form, terms, dissipative, start, decimate=(1,)):
        self.name, self.rig, self.form, self.terms = name, rig, form, terms
        self.dissipative, self.start, self.decimate = dissipative, start, decimate
        self.small = []  # names of a smaller library that a user who knows the rig would put there; both are tried
        self.fit, self.held, self.fit_files, self.held_files, self.channel = [], [], [], [], None

    def add(self, held, path, keep, output, inputs, peers=None):
        """Rows that `keep` chooses, written for obsid; of them those of `peers` for the peers."""
        header, text, data = read(path)
        rows = np.flatnonzero(keep(data))
        file = FOLDER / f"{self.name.replace(',', '').replace(' ', '_')}_{'held_out' if held else 'fit'}_{len(self.held if held else self.fit)}.csv"
        with open(file, "w", newline="") as out:
            csv.writer(out, lineterminator="\n").writerows([header, *(text[row] for row in rows)])
        if peers is not None:
            rows = np.flatnonzero(keep(data) & peers(data))
        (self.held_files if held else self.fit_files).append(file)
        (self.held if held else self.fit).append((data[rows, 0], output(data[rows]), inputs(data[rows])))


def none(data):
    return np.zeros((len(data), 0))


def pendulum(recordings):
    terms = {"1": lambda y, v: 1 + 0 * y, "y": lambda y, v: y, "sin y": lambda y, v: np.sin(y), "cos y": lambda y, v: np.cos(y),
             "y^3": lambda y, v: y**3, "v": lambda y, v: v, "|v|v": lambda y, v: abs(v) * v, "v^3": lambda y, v: v**3,
             "sign v": lambda y, v: np.sign(v)}
    case = Case("single pendulum", "single_pendulum", "second", terms, ["v", "|v|v", "v^3", "sign v"], 50, (1, 5, 10))
    case.channel, case.small = "angle", ["sin y", "v", "|v|v", "sign v"]
    path = recordings / "multiarm_pendulum/single_free_swing.csv.gz"
    slow = lambda d: np.arange(len(d)) % 10 == 0  # 100 Hz, as the documentation's own fits
    for held, begin, end in [(False, 0.05, 40.05), (True, 40.05, 54.9)]:
        case.add(held, path, lambda d: slow(d) & (d[:, 0] >= begin) & (d[:, 0] < end), lambda d: d[:, 1] - np.pi, none)
    return case


def damper(recordings):
    def inputs(d):  # cm, and cm/s from the displacement
        x = 100 * d[:, 1]
        return np.c_[x, savgol_filter(x, 21, 2, deriv=1, delta=d[1, 0] - d[0, 0])]

    terms = {"x": lambda y, x, v: x, "x^3": lambda y, x, v: x**3, "v": lambda y, x, v: v, "|v|v": lambda y, x, v: abs(v) * v,
             "sign v": lambda y, x, v: np.sign(v), "F": lambda y, x, v: y, "F|v|": lambda y, x, v: y * abs(v),
             "|F|v": lambda y, x, v: abs(y) * v, "F^2 v": lambda y, x, v: y * y * v, "1": lambda y, x, v: 1 + 0 * y}
    case = Case("friction damper", "friction_damper", "memory", terms, ["F|v|", "F"], 1, (8, 16))
    case.channel, case.small, case.static = "force", ["v", "F|v|"], ["x", "x^3", "v", "|v|v", "sign v", "1"]
    for held, file in [(False, "0.5Hz_1in"), (False, "1Hz_0.5in"), (True, "1Hz_1in"), (True, "2Hz_0.5in"), (True, "0.5Hz_0.5in")]:
        path = recordings / f"brfd_friction_backlash/sine_{file}_30lb.csv"
        case.add(held, path, lambda d: d[:, 0] >= 0, lambda d: d[:, 3] / 1e3, inputs)
    case.unit = 1e3  # kN
    return case


def cubesat(recordings):
    terms = {"on": lambda y, v, u: u, "w": lambda y, v, u: y, "|w|w": lambda y, v, u: abs(y) * y, "sign w": lambda y, v, u: np.sign(y),
             "w'": lambda y, v, u: v, "|w|w'": lambda y, v, u: abs(y) * v, "1": lambda y, v, u: 1 + 0 * y}
    case = Case("cubesat gyro step", "cubesat_gyro_step", "either", terms, ["w", "|w|w", "sign w"], 1, (1, 3))
    case.channel, case.small = "rate_z", ["on", "w", "w'"]
    on = lambda d: np.any([(d[:, 0] >= begin) & (d[:, 0] < begin + 40) for begin in WHEEL_ON_S], axis=0)[:, None] * 1.0
    for held, begin, end, first, last in [(False, 0, 45, 0, 32), (True, 45, 101, 50, 84)]:  # the plant's segments for the peers
        case.add(held, recordings / "cubesat_adcs/step_response.csv", lambda d: (d[:, 0] >= begin) & (d[:, 0] < end),
                 lambda d: d[:, 3], on, lambda d: (d[:, 0] >= first) & (d[:, 0] < last))
    return case


def disc(recordings, channel):
    spin = channel == "rate_z"
    if spin:
        terms = {"1": lambda y: 1 + 0 * y, "w": lambda y: y, "|w|w": lambda y: abs(y) * y, "sign w": lambda y: np.sign(y)}
        case = Case("thrown disc, spin", "thrown_disc", "first", terms, ["w", "|w|w", "sign w"], 20)
    else:  # the measured rates are given as inputs
        names = {"wx": 0, "wy": 1, "wz": 2}
        terms = {"1": lambda y, *u: 1 + 0 * y} | {name: (lambda y, *u, k=k: u[k]) for name, k in names.items()}
        terms |= {f"{a} {b}": (lambda y, *u, i=i, j=j: u[i] * u[j]) for a, i in names.items() for b, j in names.items() if i <= j}
        case = Case("thrown disc, acc. x", "thrown_disc", "static", terms, [], 1)
    case.channel = channel
    free = lambda d: (d[:, 1] >= 1612) & (d[:, 1] < 1822)
    for held, begin, end in [(False, 0, 1717), (True, 1717, 1e9)]:
        inputs = none if spin else lambda d: d[:, 5:8]
        case.add(held, recordings / "flatball_freeflight/throw_imu.csv", lambda d: (d[:, 1] >= begin) & (d[:, 1] < end),
                 lambda d: d[:, 7 if spin else 2], inputs, free)
    return case


def ball(recordings, name):
    terms = {"1": lambda y, v: 1 + 0 * y, "v": lambda y, v: v, "|v|v": lambda y, v: abs(v) * v}
    case = Case(name.replace("_", " "), "ball_drop", "second", terms, ["v", "|v|v"], 10)
    case.channel, case.small = "height", ["1", "|v|v"]
    for held in (False, True):
        case.add(held, recordings / f"ball_drops/{name}.csv", lambda d: d[:, 1] == 1 + held, lambda d: d[:, 2], none)
    return case


def scores(measured, predicted):
    """rms, and fit 100 (1 - |e| / |y - mean y|), over all records; None where a prediction ran away."""
    if any(p is None or not np.all(np.isfinite(p)) for p in predicted):
        return None
    error = np.concatenate([y - p for y, p in zip(measured, predicted)])
    if np.max(np.abs(error)) > 1e9:
        return None
    spread = np.concatenate([y - y.mean() for y in measured])
    return np.sqrt(np.mean(error**2)), 100 * (1 - np.linalg.norm(error) / np.linalg.norm(spread))


def slower(records, step):
    return [tuple(column[::step] for column in record) for record in records]


def validation(records):
    if len(records) > 1:
        return records[:-1], records[-1:]
    cut = 7 * len(records[0][0]) // 10
    return [tuple(column[:cut] for column in records[0])], [tuple(column[cut:] for column in records[0])]


def tried(setting, records, asked):
    """Fitted and asked; None where the peer cannot (a record too short for its lags, a model that runs away)."""
    try:
        model = setting.fit(records)
        return scores([record[1] for record in asked], [model.predict(record) for record in asked])
    except (ValueError, IndexError, FloatingPointError, OverflowError, np.linalg.LinAlgError, TypeError):
        return None


def peer(case, settings):
    begin, best = time.process_time(), None
    for step in case.decimate:
        fit = slower(case.fit, step)
        first, last = validation(fit)
        for setting in settings(case):
            found = tried(setting, first, last)
            if found and (best is None or found[0] < best[0]):
                best = found[0], setting, step
    if best is None:
        return None, 0, "no setting ran", time.process_time() - begin
    _, setting, step = best
    found = tried(setting, slower(case.fit, step), slower(case.held, step))
    return found, setting.terms(), setting.physical(), time.process_time() - begin


def obsid(case):
    """What `obsid diagnose --json` says, and its CPU seconds; asked once for files of the same content."""
    key = tuple(file.read_bytes() for file in case.fit_files + case.held_files)
    if key not in ASKED:
        ASKED[key] = ask(case)
    return ASKED[key]


def ask(case):
    command = [os.environ["OBSID"]] if os.environ.get("OBSID") else ["cargo", "run", "--release", "--quiet", "--"]
    command += ["diagnose", *map(str, case.fit_files), "--plant", str(RIGS / f"{case.rig}.toml"), "--threads", "1", "--json"]
    command += [word for file in case.held_files for word in ("--held-out", str(file))]
    before = os.times()
    said = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    after = os.times()
    return json.loads(said), after.children_user - before.children_user


def line(tool, found, terms, physical, seconds):
    rms, fit = (f"{found[0]:>12.4g}", f"{found[1]:>9.1f}") if found else (f"{'-':>12}", f"{'-':>9}")
    print(f"{'':<22}{tool:<18}{rms}{fit}{terms:>7}{seconds:>9}  {physical}", flush=True)


def obsid_lines(case):
    said, seconds = obsid(case)
    row = next((row for row in said["held_out"]["channels"] if row["name"] == case.channel), None)
    effects = [effect for effect in said["effects"] if effect["status"] in ("confirmed", "unconfirmed")]
    signed = [e for e in effects if not e["kind"].startswith("sensor") and e["kind"] != "joint_asymmetric_friction"]  # it has either sign
    negative = [p["name"] for e in signed for p in e["parameters"] if p["name"] in ("force", "damping", "coefficient") and p["value"] < 0]
    names = ", ".join(f"{effect['kind']} ({effect['status']})" for effect in effects) or "adds nothing"
    before, after = ((row["rms_before"], row["fit_percent_before"]), (row["rms_after"], row["fit_percent_after"])) if row else (None, None)
    line("nominal plant", before, "0", "", "")
    line("obsid", after if effects else before, str(len(effects)), f"{'no: ' + ', '.join(negative) if negative else 'yes'}: "
         f"{said['verdict']}: {names}", f"{seconds:.1f}")


def compare(case):
    print(case.name)
    obsid_lines(case)
    ran = True
    for tool, settings in [("PySINDy", sindy_settings), ("SysIdentPy", narx_settings)]:
        found, terms, physical, seconds = peer(case, settings)
        if found and hasattr(case, "unit"):
            found = found[0] * case.unit, found[1]
        line(tool, found, str(terms), physical, f"{seconds:.1f}")
        ran = ran and found is not None
    return ran


def main():
    folder = pathlib.Path(os.environ.get("OBSID_RECORDINGS") or ROOT.parent / "shared/recordings")
    if not (folder / "README.md").is_file():
        print(f"skipped: no recordings in {folder} (set OBSID_RECORDINGS)")
        return 1 if "recordings" in os.environ.get("OBSID_REQUIRE", "") else 0
    balls = [lambda r, name=name: ball(r, name) for name in ("yellow_whiffle_ball", "whiffle_ball_1", "tennis_ball", "golf_ball", "bowling_ball")]
    spin, arm = (lambda r: disc(r, "rate_z")), (lambda r: disc(r, "acceleration_x"))
    print(f"{'held out, free run':<22}{'tool':<18}{'rms [SI]':>12}{'fit %':>9}{'terms':>7}{'CPU s':>9}  terms physical?")
    ran = [compare(make(folder)) for make in [pendulum, damper, cubesat, spin, arm, *balls]]
    print("cantilever\n" + " " * 22 + "a spectrum without phase: neither peer takes one; `obsid diagnose` alone")
    return 0 if all(ran) else 1


if __name__ == "__main__":
    warnings.filterwarnings("ignore")
    with tempfile.TemporaryDirectory() as temporary:
        FOLDER = pathlib.Path(temporary)
        sys.exit(main())
