"""Golden numbers for a hub with a flexible appendage, from a finite-element beam.

What: `tests/golden/appendage_fe.json`: hub-locked and hub-free frequencies, mode shapes, participations, and time
histories under a torque pulse, of a rigid hub turning in a plane with a clamped Euler-Bernoulli beam.
Why: `shared/plant` describes appendages by modes from closed-form mode functions; here no mode function enters: the
beam is polynomials on elements.
How: with theta the hub's angle and w(x, t) the deflection across the beam relative to the turned hub, a point moves
across by (r0 + x) theta + w, to first order in theta and w, so

    T = 1/2 J theta'^2 + 1/2 int rho A ((r0 + x) theta' + w')^2 dx,    V = 1/2 int EI (d2w/dx2)^2 dx,

with w = dw/dx = 0 at x = 0.

Elements: quintic Hermite (w, h w', h^2 w'' at each node), so frequencies converge with h^8 and the mesh stays coarse
enough that rounding does not take over, as it does with the usual cubic elements below 1e-9. Mesh of ELEMENTS
elements; "refinement" in the document compares with half as many. Cross-checks: cubic Hermite elements, a different
matrix; the closed-form clamped eigenvalues cos(b) cosh(b) = -1; the closed-form hub-free characteristic equation.
Histories are exact in time for the piecewise constant torque: matrix exponential, or modal closed form.
"""

import numpy as np
import scipy
from scipy.linalg import eigh, expm
from scipy.optimize import brentq

import golden

FILE = "appendage_fe.json"
SOURCES = ["appendage_fe.py"]
LENGTH_M, MASS_PER_LENGTH_KG_M, BENDING_STIFFNESS_N_M2 = 5.0, 2.0, 4000.0
ROOT_RADIUS_M, HUB_INERTIA_KG_M2 = 0.5, 66.67
DAMPING_RATIOS = [0.005, 0.008]
TORQUE_NM, PULSE_END_S, SAMPLE_RATE_HZ, SAMPLES = 2.0, 1.0, 50.0, 100
ELEMENTS, MODES = 40, 5
SENSORS_X_M = [0.5 * number for number in range(1, 11)]
# Rounding of the eigenvalue solver; truncation is below it, see `refinement`.
BOUND_FREQUENCY, BOUND_SHAPE, BOUND_HISTORY = 1e-9, 1e-8, 1e-8
# Cubic elements, 80 of them: truncation (beta h)^4 / 1440 at the fifth mode, shapes and participations somewhat worse.
BOUND_CUBIC, BOUND_CUBIC_SHAPE = 2e-6, 2e-5

TEXT = (
    "Rigid hub turning in a plane about its axis, with a uniform Euler-Bernoulli beam clamped at the radius "
    "root_radius_m and reaching out to root_radius_m + length_m. Linear: small angle, small deflection, no "
    "centrifugal stiffening. hub_inertia_kg_m2 is the hub's alone about its axis; total_inertia_kg_m2 adds the "
    "undeformed beam. x runs from the root, 0 to length_m; w is the deflection across the beam relative to the hub, "
    "positive in the direction in which a positive hub rate moves the beam. Clamped (hub-locked) modes phi_i are "
    "normalised to unit modal mass, int rho A phi_i^2 dx = 1, and signed so that the tip is positive. "
    "participation_rotation_i = int rho A (root_radius + x) phi_i dx, participation_translation_i = int rho A phi_i "
    "dx; then J_total theta'' + sum_i p_i q_i'' = torque, p_i theta'' + q_i'' + 2 zeta_i w_i q_i' + w_i^2 q_i = 0. "
    "shape: phi_i at sensors_x_m. Hub-free modes are those of the whole system with no torque, the rigid rotation "
    "left out, of unit modal mass, tip positive: hub_angle is theta in the mode, shape is the total displacement "
    "(root_radius + x) theta + w at sensors_x_m. Histories: at rest before t = 0; torque torque_nm for 0 <= t < "
    "pulse_end_s; values at t_s, right-hand limits where they jump (t = 0 and t = pulse_end_s). "
    "tip_tangential_acceleration_m_s2 = (root_radius + length) theta'' + w''(tip). Each history says to which clamped "
    "modes the beam is restricted; 'all' is the whole finite-element model, whose hub rate and tip deflection are "
    "those of the beam itself. Its tip acceleration is not given: the torque's step excites every mode of an undamped "
    "beam and the series does not settle. refinement: greatest relative difference between the mesh of `elements` and "
    "half as many."
)


def hermite(nodal_derivatives):
    """Shape functions on [0, 1] as polynomials: at either end the value and its first derivatives are the unknowns."""
    size = 2 * nodal_derivatives
    conditions = np.zeros((size, size))
    for end in (0, 1):
        for order in range(nodal_derivatives):
            for power in range(order, size):
                factor = np.prod(np.arange(power - order + 1, power + 1, dtype=float))
                conditions[end * nodal_derivatives + order, power] = factor * (1.0 if power == order or end else 0.0)
    return [np.polynomial.Polynomial(column) for column in np.linalg.inv(conditions).T]


class Beam:
    """Finite elements of the clamped beam: K, M, and the mass coupling with the hub's rotation and translation."""

    def __init__(self, elements, nodal_derivatives):
        h = LENGTH_M / elements
        shapes = hermite(nodal_derivatives)
        nodes, weights = np.polynomial.legendre.leggauss(2 * nodal_derivatives)
        s, weights = (nodes + 1) / 2, weights / 2
        value = np.array([shape(s) for shape in shapes])
        curvature = np.array([shape.deriv(2)(s) for shape in shapes])
        mass = MASS_PER_LENGTH_KG_M * h * (value * weights) @ value.T
        stiffness = BENDING_STIFFNESS_N_M2 / h**3 * (curvature * weights) @ curvature.T
        size = nodal_derivatives * (elements + 1)
        k, m, rotation, translation = np.zeros((size, size)), np.zeros((size, size)), np.zeros(size), np.zeros(size)
        for element in range(elements):
            here = slice(nodal_derivatives * element, nodal_derivatives * (element + 2))
            radius = ROOT_RADIUS_M + h * (element + s)
            k[here, here] += stiffness
            m[here, here] += mass
            translation[here] += MASS_PER_LENGTH_KG_M * h * value @ weights
            rotation[here] += MASS_PER_LENGTH_KG_M * h * value @ (weights * radius)
        # Clamped: deflection and slope at the root vanish.
        self.k, self.m = k[2:, 2:], m[2:, 2:]
        self.rotation, self.translation = rotation[2:], translation[2:]
        per_element = elements / LENGTH_M
        self.sensors = [nodal_derivatives * round(x * per_element) - 2 for x in SENSORS_X_M]
        self.tip = self.sensors[-1]

    def total_inertia(self):
        outer = ROOT_RADIUS_M + LENGTH_M
        return HUB_INERTIA_KG_M2 + MASS_PER_LENGTH_KG_M * (outer**3 - ROOT_RADIUS_M**3) / 3

    def clamped_modes(self, count):
        """Angular frequencies and mode columns. Solved for 1/w^2, whose greatest values are the wanted ones."""
        inverse_square, columns = eigh(self.m, self.k)
        inverse_square, columns = inverse_square[::-1][:count], columns[:, ::-1][:, :count]
        columns = columns / np.sqrt(np.einsum("ij,ij->j", columns, self.m @ columns))
        return inverse_square**-0.5, columns * np.sign(columns[self.tip])

    def system(self):
        """Mass and stiffness of [theta, beam unknowns]."""
        size = len(self.rotation) + 1
        m, k = np.zeros((size, size)), np.zeros((size, size))
        m[0, 0] = self.total_inertia()
        m[0, 1:] = m[1:, 0] = self.rotation
        m[1:, 1:], k[1:, 1:] = self.m, self.k
        return m, k

    def free_modes(self, count):
        """Hub-free elastic modes. The hub's angle follows from zero angular momentum, J theta + rotation . w = 0."""
        inertia = self.total_inertia()
        reduced = self.m - np.outer(self.rotation, self.rotation) / inertia
        inverse_square, beam = eigh(reduced, self.k)
        inverse_square, beam = inverse_square[::-1][:count], beam[:, ::-1][:, :count]
        beam = beam / np.sqrt(np.einsum("ij,ij->j", beam, reduced @ beam))
        angle = -self.rotation @ beam / inertia
        sign = np.sign((ROOT_RADIUS_M + LENGTH_M) * angle + beam[self.tip])
        return inverse_square**-0.5, angle * sign, beam * sign


def modal_data(beam):
    clamped_rad_s, clamped = beam.clamped_modes(MODES)
    free_rad_s, angle, free = beam.free_modes(MODES)
    radius = ROOT_RADIUS_M + np.array(SENSORS_X_M)
    return {
        "clamped_modes": [
            {
                "frequency_hz": clamped_rad_s[i] / (2 * np.pi),
                "participation_rotation_kg_sqrt_m": beam.rotation @ clamped[:, i],
                "participation_translation_kg_sqrt": beam.translation @ clamped[:, i],
                "shape": clamped[beam.sensors, i],
            }
            for i in range(MODES)
        ],
        "free_modes": [
            {
                "frequency_hz": free_rad_s[i] / (2 * np.pi),
                "hub_angle": angle[i],
                "shape": radius * angle[i] + free[beam.sensors, i],
            }
            for i in range(MODES)
        ],
    }


def sample_times():
    return np.arange(SAMPLES) / SAMPLE_RATE_HZ


def restricted_history(beam, damping_ratios):
    """The beam moves in its first clamped modes only, each damped; matrix exponential from sample to sample."""
    count = len(damping_ratios)
    omega, columns = beam.clamped_modes(count)
    p = beam.rotation @ columns
    mass = np.eye(count + 1)
    mass[0, 0] = beam.total_inertia()
    mass[0, 1:] = mass[1:, 0] = p
    damping = np.diag([0.0, *(2 * np.array(damping_ratios) * omega)])
    stiffness = np.diag([0.0, *omega**2])
    size = count + 1
    state_matrix = np.zeros((2 * size + 1, 2 * size + 1))
    state_matrix[:size, size : 2 * size] = np.eye(size)
    state_matrix[size : 2 * size, :size] = -np.linalg.solve(mass, stiffness)
    state_matrix[size : 2 * size, size : 2 * size] = -np.linalg.solve(mass, damping)
    state_matrix[size : 2 * size, 2 * size] = np.linalg.solve(mass, np.eye(size)[0])
    step = expm(state_matrix / SAMPLE_RATE_HZ)
    tip = columns[beam.tip]
    outer = ROOT_RADIUS_M + LENGTH_M
    rows, x = [], np.zeros(2 * size + 1)
    for t in sample_times():
        # The input is the last state; round(): t is a whole number of samples.
        x[-1] = TORQUE_NM if round(t * SAMPLE_RATE_HZ) < round(PULSE_END_S * SAMPLE_RATE_HZ) else 0.0
        change = state_matrix @ x
        acceleration = outer * change[size] + tip @ change[size + 1 : 2 * size]
        rows.append((x[-1], x[0], x[size], tip @ x[1:size], acceleration))
        x = step @ x
    names = ["torque_nm", "hub_angle_rad", "hub_rate_rad_s", "tip_deflection_m", "tip_tangential_acceleration_m_s2"]
    return {
        "beam_restricted_to": f"clamped modes 1..{count}",
        "damping_ratios": damping_ratios,
        **dict(zip(names, np.array(rows).T)),
    }


def full_history(beam):
    """All unknowns, undamped: rigid rotation plus each hub-free mode's step responses, in closed form."""
    omega, angle, columns = beam.free_modes(len(beam.rotation))
    t, inertia = sample_times(), beam.total_inertia()

    def after_step(since):
        """(angle, rate, tip deflection) at the times `since` a unit step of torque."""
        s = np.maximum(since, 0.0)
        phase = np.outer(s, omega)
        # 1 - cos = 2 sin^2(half): no cancellation for slow modes.
        amplitude = 2 * np.sin(phase / 2) ** 2 / omega**2
        return np.array(
            [
                s**2 / (2 * inertia) + amplitude @ angle**2,
                s / inertia + (np.sin(phase) / omega) @ angle**2,
                amplitude @ (angle * columns[beam.tip]),
            ]
        )

    response = TORQUE_NM * (after_step(t) - after_step(t - PULSE_END_S))
    return {
        "beam_restricted_to": "all",
        "damping_ratios": [],
        "torque_nm": np.where(np.arange(SAMPLES) < round(PULSE_END_S * SAMPLE_RATE_HZ), TORQUE_NM, 0.0),
        **dict(zip(["hub_angle_rad", "hub_rate_rad_s", "tip_deflection_m"], response)),
    }


def histories(beam):
    return [
        {"name": "undamped_all", **full_history(beam)},
        {"name": "undamped_clamped_modes_1_to_5", **restricted_history(beam, [0.0] * MODES)},
        {"name": "undamped_clamped_modes_1_2", **restricted_history(beam, [0.0] * 2)},
        {"name": "damped_clamped_modes_1_2", **restricted_history(beam, DAMPING_RATIOS)},
    ]


MODAL_KEYS = [
    ("clamped_modes", "frequency_hz", BOUND_FREQUENCY, BOUND_CUBIC),
    ("clamped_modes", "participation_rotation_kg_sqrt_m", BOUND_SHAPE, BOUND_CUBIC_SHAPE),
    ("clamped_modes", "participation_translation_kg_sqrt", BOUND_SHAPE, BOUND_CUBIC_SHAPE),
    ("clamped_modes", "shape", BOUND_SHAPE, BOUND_CUBIC_SHAPE),
    ("free_modes", "frequency_hz", BOUND_FREQUENCY, BOUND_CUBIC),
    ("free_modes", "hub_angle", BOUND_SHAPE, BOUND_CUBIC_SHAPE),
    ("free_modes", "shape", BOUND_SHAPE, BOUND_CUBIC_SHAPE),
]
HISTORY_KEYS = ["hub_angle_rad", "hub_rate_rad_s", "tip_deflection_m", "tip_tangential_acceleration_m_s2"]


def modal_differences(a, b):
    """(kind, quantity, greatest relative difference over the modes); shapes relative to the mode's greatest value."""
    for kind, key, *_ in MODAL_KEYS:
        pairs = zip(a[kind], b[kind], strict=True)
        yield kind, key, max(golden.relative_difference(x[key], y[key]) for x, y in pairs)


def history_differences(a, b):
    for x, y in zip(a, b, strict=True):
        for key in HISTORY_KEYS:
            if key in x:
                yield x["name"], key, golden.relative_difference(x[key], y[key])


def clamped_closed_form_hz():
    roots = []
    for number in range(1, MODES + 1):
        centre = (number - 0.5) * np.pi
        roots.append(brentq(lambda b: np.cos(b) + 1 / np.cosh(b), centre - 0.5, centre + 0.5, xtol=1e-15, rtol=1e-15))
    return (np.array(roots) / LENGTH_M) ** 2 * np.sqrt(BENDING_STIFFNESS_N_M2 / MASS_PER_LENGTH_KG_M) / (2 * np.pi)


def free_closed_form_hz():
    """y = A cos + B sin + C cosh + D sinh of beta x, with y(0) = r0 y'(0), free tip, and the hub's moment balance.

    Hub: J theta'' = EI (y''(0) - r0 y'''(0)), i.e. -J w^2 y'(0) = EI (y''(0) - r0 y'''(0)), w^2 = EI beta^4 / rho A.
    """
    r0, ell = ROOT_RADIUS_M, LENGTH_M

    def determinant(beta):
        c, s, decay = np.cos(beta * ell), np.sin(beta * ell), np.exp(-beta * ell)
        # Hyperbolic pair as exp(-beta x) and exp(beta (x - L)): bounded.
        ratio = HUB_INERTIA_KG_M2 * beta**3 / MASS_PER_LENGTH_KG_M
        b = beta
        return np.linalg.det(
            [
                [1.0, -r0 * b, 1.0 + r0 * b, decay * (1.0 - r0 * b)],
                [-c, -s, decay, 1.0],
                [s, -c, -decay, 1.0],
                [-1.0, r0 * b + ratio, 1.0 + r0 * b - ratio, decay * (1.0 - r0 * b + ratio)],
            ]
        )

    grid = np.linspace(0.05, 4.0, 4000)
    values = [determinant(beta) for beta in grid]
    pairs = zip(grid, grid[1:], values, values[1:])
    roots = [brentq(determinant, a, b, xtol=1e-15, rtol=1e-15) for a, b, at_a, at_b in pairs if at_a * at_b < 0]
    beta = np.array(roots[:MODES])
    return beta**2 * np.sqrt(BENDING_STIFFNESS_N_M2 / MASS_PER_LENGTH_KG_M) / (2 * np.pi)


def cross_check(modal, table):
    for kind, closed_form in [("clamped_modes", clamped_closed_form_hz()), ("free_modes", free_closed_form_hz())]:
        for mode, expected in zip(modal[kind], closed_form, strict=True):
            difference = golden.relative_difference(mode["frequency_hz"], expected)
            table.add("appendage", "quintic FE", "closed form", f"{kind} frequency_hz", difference, BOUND_FREQUENCY)
    cubic = modal_data(Beam(2 * ELEMENTS, 2))
    bounds = {(kind, key): bound for kind, key, _, bound in MODAL_KEYS}
    for kind, key, difference in modal_differences(modal, cubic):
        table.add("appendage", "quintic FE", "cubic FE", f"{kind} {key}", difference, bounds[kind, key])


def refinement(modal, history):
    coarse = Beam(ELEMENTS // 2, 3)
    rows = {}
    for kind, key, difference in modal_differences(modal, modal_data(coarse)):
        rows.setdefault(kind, {})[key] = difference
    for name, key, difference in history_differences(history, histories(coarse)):
        rows.setdefault(name, {})[key] = difference
    return rows


def document(table):
    beam = Beam(ELEMENTS, 3)
    modal, history = modal_data(beam), histories(beam)
    cross_check(modal, table)
    return {
        "format": "obsid golden appendage_fe 1",
        "generated_by": "tests/peers/run dynamics --write (appendage_fe.py)",
        "generator_sha256": golden.source_sha256(SOURCES),
        "engines": {"numpy": np.__version__, "scipy": scipy.__version__},
        "conventions": TEXT,
        "length_m": LENGTH_M,
        "mass_per_length_kg_m": MASS_PER_LENGTH_KG_M,
        "bending_stiffness_n_m2": BENDING_STIFFNESS_N_M2,
        "root_radius_m": ROOT_RADIUS_M,
        "hub_inertia_kg_m2": HUB_INERTIA_KG_M2,
        "total_inertia_kg_m2": beam.total_inertia(),
        "element": "quintic Hermite",
        "elements": ELEMENTS,
        "refinement": refinement(modal, history),
        "sensors_x_m": SENSORS_X_M,
        **modal,
        "torque_nm": TORQUE_NM,
        "pulse_end_s": PULSE_END_S,
        "t_s": sample_times(),
        "histories": history,
    }


def compare_with_golden(fresh, committed, table):
    bounds = {(kind, key): bound for kind, key, bound, _ in MODAL_KEYS}
    for kind, key, difference in modal_differences(committed, fresh):
        table.add("appendage", "golden", "quintic FE", f"{kind} {key}", difference, bounds[kind, key])
    for name, _, difference in history_differences(committed["histories"], fresh["histories"]):
        table.add("appendage", "golden", "quintic FE", f"history {name}", difference, BOUND_HISTORY)
