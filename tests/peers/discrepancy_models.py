"""What `discrepancy.py` tries of PySINDy and SysIdentPy: their settings, fits and free runs.

PySINDy: derivatives by Savitzky-Golay, a library of the terms that a user would put there, STLSQ over a ladder of thresholds; in free run
from a state fitted to the first stretch, by RK4 on the model's own equations (its solve_ivp takes minutes where there is a sign()).
SysIdentPy: polynomial NARX by FROLS, order by AIC or BIC, in free run from the first samples measured.
"""
import itertools
import math

import numpy as np
from scipy.optimize import least_squares
from scipy.signal import savgol_filter

LIBRARY_MAX = 100  # candidate terms of a polynomial NARX: FROLS needs minutes beyond
WINDOWS = [5, 9, 19]  # of Savitzky and Golay [samples]
THRESHOLDS = [1e-3, 1e-2, 0.05, 0.2]  # of the norm of what is explained, columns of unit norm


class Sindy:
    """One setting of PySINDy: which form of states, which terms, which threshold."""

    def __init__(self, case, form, names, threshold, window):
        self.case, self.form, self.names, self.threshold, self.window = case, form, names, threshold, window

    def states(self, record):
        t, y, _ = record
        dt, smooth = t[1] - t[0], lambda deriv: savgol_filter(y, self.window, 3, deriv=deriv, delta=dt)
        if self.form == "static":
            return y[:, None], y[:, None]
        if self.form == "first":
            return smooth(0)[:, None], smooth(1)[:, None]
        return np.c_[smooth(0), smooth(1)], np.c_[smooth(1), smooth(2)]

    def term(self, name):  # the library of the either-case has a rate argument that first-order models lack
        function = self.case.terms[name]
        return (lambda y, u: function(y, 0 * y, u)) if self.case.form == "either" and self.form == "first" else function

    def fit(self, records):
        import pysindy

        pairs = [self.states(record) for record in records]
        inputs = [record[2] for record in records] if records[0][2].shape[1] else None
        functions = [self.term(name) for name in self.names]
        arity = pairs[0][0].shape[1] + records[0][2].shape[1]
        fixed = [eval(f"lambda {','.join('abcdef'[:arity])}: f({','.join('abcdef'[:arity])})", {"f": f}) for f in functions]
        scale = np.linalg.norm(np.concatenate([x_dot[:, -1] for _, x_dot in pairs]))
        optimizer = pysindy.STLSQ(threshold=self.threshold * scale, alpha=1e-9, normalize_columns=True)
        model = pysindy.SINDy(optimizer=optimizer, feature_library=pysindy.CustomLibrary(fixed, interaction_only=True))
        dt = records[0][0][1] - records[0][0][0]
        model.fit([x for x, _ in pairs], t=dt, x_dot=[d for _, d in pairs], u=inputs)
        self.law, self.functions = np.asarray(model.coefficients())[-1], functions
        return self

    def slope(self, x, u):
        with np.errstate(all="ignore"):
            last = sum(c * f(*x, *u) for c, f in zip(self.law, self.functions) if c)
        return np.array([last]) if len(x) == 1 else np.array([x[1], last])

    def run(self, x, t, u):
        out = [x]
        for k in range(len(t) - 1):
            dt, a, b = t[k + 1] - t[k], u[k], u[k + 1]
            k1 = self.slope(x, a)
            k2 = self.slope(x + dt / 2 * k1, (a + b) / 2)
            k3 = self.slope(x + dt / 2 * k2, (a + b) / 2)
            x = x + dt / 6 * (k1 + 2 * k2 + 2 * k3 + self.slope(x + dt * k3, b))
            if not np.all(np.abs(x) < 1e9):
                return None
            out.append(x)
        return np.asarray(out)[:, 0]

    def predict(self, record):
        t, y, u = record
        if self.form == "static":
            return sum(c * f(y, *u.T) for c, f in zip(self.law, self.functions)) + 0 * y
        start, n = self.states(record)[0][0], self.case.start
        if n > 1:
            def residual(x):
                said = self.run(x, t[:n], u[:n])
                return np.full(n, 1e6) if said is None else said - y[:n]
            start = least_squares(residual, start, x_scale="jac", max_nfev=20).x
        return self.run(start, t, u)

    def terms(self):
        return int(np.count_nonzero(self.law))

    def physical(self):
        if not self.case.dissipative and self.form == "static":
            return "yes"
        # Damping and friction slow down (in the force of a damper: they are added).
        sign, names = (-1, ["v", "|v|v", "sign v"]) if self.case.form == "memory" and self.form == "static" else (1, self.case.dissipative)
        wrong = [name for name, c in zip(self.names, self.law) if name in names and sign * c > 0]
        return f"no: {', '.join(wrong)} drives" if wrong else "yes"


class Narx:
    """One setting of SysIdentPy: degree, lags, inputs, criterion."""

    def __init__(self, degree, lags, criterion, sign):
        self.degree, self.lags, self.criterion, self.sign = degree, lags, criterion, sign

    def inputs(self, u):  # its documentation feeds the sign of the rate where there is hysteresis
        return np.c_[u, np.sign(u[:, -1])] if self.sign else u

    def fit(self, records):
        from sysidentpy.basis_function import Polynomial
        from sysidentpy.model_structure_selection import FROLS
        from sysidentpy.parameter_estimation import LeastSquares

        y = np.concatenate([record[1] for record in records])[:, None]
        u = np.concatenate([self.inputs(record[2]) for record in records])
        lags = list(range(1, self.lags + 1))
        self.none = u.shape[1] == 0
        self.model = FROLS(order_selection=True, n_info_values=20, info_criteria=self.criterion, ylag=self.lags, estimator=LeastSquares(),
                           xlag=[lags] * u.shape[1] if u.shape[1] > 1 else lags, basis_function=Polynomial(degree=self.degree),
                           model_type="NAR" if self.none else "NARMAX")
        self.model.fit(X=None if self.none else u, y=y)
        return self

    def predict(self, record):
        _, y, u = record
        first, u = y[: self.model.max_lag, None], self.inputs(u)
        with np.errstate(all="ignore"):
            if self.none:
                said = self.model.predict(X=None, y=first, forecast_horizon=len(y) - len(first))
            else:
                said = self.model.predict(X=u, y=first)
        return said[: len(y), 0] if len(said) >= len(y) else None

    def terms(self):
        return len(self.model.final_model)

    def physical(self):
        return "has no physical terms"


def sindy_settings(case):
    forms = {"memory": ["first", "static"], "either": ["first", "second"]}.get(case.form, [case.form])
    for form, names in itertools.product(forms, [list(case.terms), case.small]):
        if form == "static" and case.form == "memory":
            names = [name for name in names if name in case.static]
        if form == "first" and case.form == "either":
            names = [name for name in names if "'" not in name]
        windows = WINDOWS if form != "static" else WINDOWS[:1]
        for window, threshold in itertools.product(windows, THRESHOLDS) if names else []:
            yield Sindy(case, form, names, threshold, window)


def narx_settings(case):
    signs = (False, True) if case.form == "memory" else (False,)
    for degree, lags, criterion, sign in itertools.product((1, 2, 3), (2, 3, 4), ("aic", "bic"), signs):
        variables = lags * (1 + case.fit[0][2].shape[1] + sign)
        if math.comb(variables + degree, degree) <= LIBRARY_MAX:
            yield Narx(degree, lags, criterion, sign)
