"""Golden trajectories of a planar hub with a sloshing tank, from Newton's equations written for this file.

What: `tests/golden/planar_tank.json`: one hub with a slosh mass on two perpendicular springs, one with a pendulum;
pose, rates and slosh coordinates over 60 s under constant body-fixed thrust, large rotation and all coupling kept.
Why: `shared/plant` carries a tank as joints of a general multibody formulation; here each body has its own free-body
diagram and nothing else.
How: derivation in DERIVATION below; integrated with DOP853 at rtol 1e-12. Cross-checks: the same accelerations from
Pinocchio with the tank as joints (articulated-body algorithm); the trajectory with steps ten times shorter; the energy
balance (work of the thrust minus loss in the damper), integrated along.
"""

import numpy as np
import scipy
from scipy.integrate import solve_ivp

import golden
from pinocchio_engine import Pinocchio
from rigid_bodies import Body, System, quaternion_to_rotation

FILE = "planar_tank.json"
SOURCES = ["planar_tank.py"]
DURATION_S, STATES = 60.0, 50
RTOL, ATOL = 1e-12, 1e-13
# Step control at 1e-12 per step over some hundred steps.
BOUND_TRAJECTORY = 1e-9
BOUND_ACCELERATION = 1e-12

DERIVATION = (
    "Plane, inertial axes x, y, angle positive from x to y, SI units, no gravity. Hub: mass M, inertia I about its "
    "centre of mass, which is at r = (x, y); attitude theta, rate w = theta'. All below in hub axes: A = R(theta)^T "
    "r'' is the hub's inertial acceleration, J turns by +90 degrees, a x b = a_x b_y - a_y b_x. The thrust F = "
    "force_body_n and the torque torque_nm are constant in hub axes, F acting at the hub's centre of mass. The slosh "
    "mass m is a point at rho (hub axes, from the hub's centre of mass), so its inertial acceleration is a_s = A + w' "
    "J rho - w^2 rho + 2 w J rho' + rho''. f is the force of the hub on the slosh mass: m a_s = f, M A = F - f. "
    "SPRINGS: rho = b + s_1 e_1 + s_2 e_2, b = tank_position_m, e_1 = (cos g, sin g), e_2 = J e_1, g = "
    "tank_angle_rad, both fixed in the hub; f = -sum (k_i s_i + c_i s_i') e_i, its reaction on the hub acts where the "
    "mass is: I w' = torque - rho x f. Hence A and w' are explicit, rho'' = f / m - A - w' J rho + w^2 rho - 2 w J "
    "rho', s_i'' = e_i . rho''. Coordinates s_1, s_2. PENDULUM: massless rod of length l from the pivot b = "
    "pivot_position_m to the point mass, rho = b + l d, d = (-cos phi, -sin phi): at phi = 0 the rod points along -x "
    "of the hub, where thrust along +x holds it; phi positive from x to y relative to the hub. The damper at the "
    "pivot puts -c phi' on the rod and +c phi' on the hub. The rod's balance of moments about the pivot gives l d x f "
    "= -c phi', so f = T d - (c phi' / l) J d with T the unknown pull along the rod; I w' = torque - b x f + c phi'; "
    "a_s = A + w' J b - w^2 b + l (w' + phi'') J d - l (w + phi')^2 d. Five linear equations for A, w', phi'', T. "
    "Coordinate phi. States: position_m and velocity_m_s of the hub's centre of mass in inertial axes, angle_rad, "
    "rate_rad_s, slosh coordinates and rates; accelerations at that state: acceleration_m_s2 in inertial axes, "
    "angular_acceleration_rad_s2, slosh_acceleration."
)

HUB = {"hub_mass_kg": 1000.0, "hub_inertia_com_kg_m2": 480.0}
SPRINGS = {
    "name": "springs",
    **HUB,
    "slosh_mass_kg": 60.0,
    "tank_position_m": [0.4, 0.7],
    "tank_angle_rad": 0.3,
    "stiffness_n_m": [60.0, 95.0],
    "damping_n_s_m": [2.5, 4.0],
    "force_body_n": [40.0, 0.0],
    "torque_nm": 0.0,
    "initial": {
        "position_m": [1.0, -2.0],
        "angle_rad": 0.3,
        "slosh": [0.15, -0.1],
        "velocity_m_s": [0.2, -0.1],
        "rate_rad_s": 0.15,
        "slosh_rate": [0.0, 0.05],
    },
}
PENDULUM = {
    "name": "pendulum",
    **HUB,
    "slosh_mass_kg": 28.3,
    "pivot_position_m": [-0.3, 0.5],
    "length_m": 0.6,
    "damping_nm_s_rad": 0.246,
    "force_body_n": [120.0, 0.0],
    "torque_nm": 0.0,
    "initial": {
        "position_m": [0.5, 0.25],
        "angle_rad": -0.4,
        "slosh": [0.5],
        "velocity_m_s": [0.1, 0.05],
        "rate_rad_s": 0.02,
        "slosh_rate": [-0.1],
    },
}

QUARTER_TURN = np.array([[0.0, -1.0], [1.0, 0.0]])


def turn(angle):
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def cross(a, b):
    return a[0] * b[1] - a[1] * b[0]


def accelerations_springs(case, rate, slosh, slosh_rate):
    """(A in hub axes, w', s'')."""
    axes = turn(case["tank_angle_rad"])
    rho, rho_dot = case["tank_position_m"] + axes @ slosh, axes @ slosh_rate
    f = -axes @ (case["stiffness_n_m"] * slosh + case["damping_n_s_m"] * slosh_rate)
    hub = (case["force_body_n"] - f) / case["hub_mass_kg"]
    angular = (case["torque_nm"] - cross(rho, f)) / case["hub_inertia_com_kg_m2"]
    transport = angular * QUARTER_TURN @ rho - rate**2 * rho + 2 * rate * QUARTER_TURN @ rho_dot
    return hub, angular, axes.T @ (f / case["slosh_mass_kg"] - hub - transport)


def accelerations_pendulum(case, rate, slosh, slosh_rate):
    """(A in hub axes, w', [phi'']); unknowns [A_x, A_y, w', phi'', T]."""
    big, small, length = case["hub_mass_kg"], case["slosh_mass_kg"], case["length_m"]
    b, phi, phi_dot = np.array(case["pivot_position_m"]), slosh[0], slosh_rate[0]
    d = -np.array([np.cos(phi), np.sin(phi)])
    across = QUARTER_TURN @ d
    damper = case["damping_nm_s_rad"] * phi_dot
    f_across = -damper / length * across
    matrix, right = np.zeros((5, 5)), np.zeros(5)
    # Hub, translation: M A + T d = F - f_across.
    matrix[:2, :2], matrix[:2, 4] = big * np.eye(2), d
    right[:2] = case["force_body_n"] - f_across
    # Hub, rotation: I w' + T (b x d) = torque - b x f_across + c phi'.
    matrix[2, 2], matrix[2, 4] = case["hub_inertia_com_kg_m2"], cross(b, d)
    right[2] = case["torque_nm"] - cross(b, f_across) + damper
    # Slosh mass: m a_s - T d = f_across.
    matrix[3:, :2] = small * np.eye(2)
    matrix[3:, 2] = small * (QUARTER_TURN @ b + length * across)
    matrix[3:, 3], matrix[3:, 4] = small * length * across, -d
    right[3:] = f_across + small * (rate**2 * b + length * (rate + phi_dot) ** 2 * d)
    solution = np.linalg.solve(matrix, right)
    return solution[:2], solution[2], solution[3:4]


ACCELERATIONS = {"springs": accelerations_springs, "pendulum": accelerations_pendulum}


def slosh_place(case, slosh, slosh_rate):
    """(rho, rho', potential energy, power lost in the damper)."""
    if case["name"] == "springs":
        axes = turn(case["tank_angle_rad"])
        energy = 0.5 * np.sum(case["stiffness_n_m"] * slosh**2)
        loss = np.sum(case["damping_n_s_m"] * slosh_rate**2)
        return case["tank_position_m"] + axes @ slosh, axes @ slosh_rate, energy, loss
    d = -np.array([np.cos(slosh[0]), np.sin(slosh[0])])
    rho = case["pivot_position_m"] + case["length_m"] * d
    loss = case["damping_nm_s_rad"] * slosh_rate[0] ** 2
    return rho, case["length_m"] * slosh_rate[0] * QUARTER_TURN @ d, 0.0, loss


def split(x, count):
    """[position 2, angle, slosh n, velocity 2, rate, slosh rate n, work] -> parts."""
    return x[:2], x[2], x[3 : 3 + count], x[3 + count : 5 + count], x[5 + count], x[6 + count : 6 + 2 * count]


def derivative(case, count, x):
    _, angle, slosh, velocity, rate, slosh_rate = split(x, count)
    hub, angular, slosh_acceleration = ACCELERATIONS[case["name"]](case, rate, slosh, slosh_rate)
    *_, loss = slosh_place(case, slosh, slosh_rate)
    to_inertial = turn(angle)
    power = case["torque_nm"] * rate + velocity @ to_inertial @ case["force_body_n"] - loss
    return np.concatenate([velocity, [rate], slosh_rate, to_inertial @ hub, [angular], slosh_acceleration, [power]])


def energy(case, x, count):
    _, angle, slosh, velocity, rate, slosh_rate = split(x, count)
    rho, rho_dot, potential, _ = slosh_place(case, slosh, slosh_rate)
    of_mass = velocity + turn(angle) @ (rate * QUARTER_TURN @ rho + rho_dot)
    hub = case["hub_mass_kg"] * velocity @ velocity + case["hub_inertia_com_kg_m2"] * rate**2
    return 0.5 * (hub + case["slosh_mass_kg"] * of_mass @ of_mass) + potential


def numbers(case):
    return {key: np.array(value) if isinstance(value, list) else value for key, value in case.items()}


def integrate(case, longest_step_s):
    initial = case["initial"]
    count = len(initial["slosh"])
    start = np.concatenate(
        [
            initial["position_m"],
            [initial["angle_rad"]],
            initial["slosh"],
            initial["velocity_m_s"],
            [initial["rate_rad_s"]],
            initial["slosh_rate"],
            [0.0],
        ]
    )
    times = DURATION_S / STATES * np.arange(1, STATES + 1)
    # Each interval ends on a step of the integrator: no dense output, whose order is lower.
    rows, x, before = [], start, 0.0
    for t in times:
        result = solve_ivp(
            lambda _, x: derivative(case, count, x),
            (before, t),
            x,
            method="DOP853",
            rtol=RTOL,
            atol=ATOL,
            max_step=longest_step_s,
        )
        x, before = result.y[:, -1], t
        rows.append(x)
    return times, start, np.array(rows)


def state_document(case, t, x):
    count = len(case["initial"]["slosh"])
    position, angle, slosh, velocity, rate, slosh_rate = split(x, count)
    hub, angular, slosh_acceleration = ACCELERATIONS[case["name"]](case, rate, slosh, slosh_rate)
    return {
        "t_s": t,
        "position_m": position,
        "angle_rad": angle,
        "slosh": slosh,
        "velocity_m_s": velocity,
        "rate_rad_s": rate,
        "slosh_rate": slosh_rate,
        "acceleration_m_s2": turn(angle) @ hub,
        "angular_acceleration_rad_s2": angular,
        "slosh_acceleration": slosh_acceleration,
    }


def as_joints(case):
    """The same system for Pinocchio: the tank as two prismatic joints or one revolute joint on a planar base."""

    def body(name, parent, joint, axis, position, angle, mass, com, inertia_z):
        rotation = quaternion_to_rotation([np.cos(angle / 2), 0.0, 0.0, np.sin(angle / 2)])
        inertia = inertia_z * np.diag([0.5, 0.5, 1.0])
        return Body(name, parent, joint, np.array(axis), np.array(position), rotation, mass, np.array(com), inertia)

    hub_inertia, mass, zero = case["hub_inertia_com_kg_m2"], case["slosh_mass_kg"], [0.0, 0.0, 0.0]
    bodies = [body("hub", -1, "free_planar", [0.0, 0.0, 1.0], zero, 0.0, case["hub_mass_kg"], zero, hub_inertia)]
    if case["name"] == "springs":
        place, angle = [*case["tank_position_m"], 0.0], case["tank_angle_rad"]
        bodies.append(body("slide", 0, "prismatic", [1.0, 0.0, 0.0], place, angle, 0.0, zero, 0.0))
        bodies.append(body("mass", 1, "prismatic", [0.0, 1.0, 0.0], zero, 0.0, mass, zero, 0.0))
    else:
        place, com = [*case["pivot_position_m"], 0.0], [-case["length_m"], 0.0, 0.0]
        bodies.append(body("bob", 0, "revolute", [0.0, 0.0, 1.0], place, 0.0, mass, com, 0.0))
    return System(case["name"], np.zeros(3), bodies)


def check_with_joints(case, rows, table):
    engine = Pinocchio(as_joints(case))
    count = len(case["initial"]["slosh"])
    for x in rows:
        position, angle, slosh, velocity, rate, slosh_rate = split(x, count)
        hub, angular, slosh_acceleration = ACCELERATIONS[case["name"]](case, rate, slosh, slosh_rate)
        if case["name"] == "springs":
            joint_force = -(case["stiffness_n_m"] * slosh + case["damping_n_s_m"] * slosh_rate)
        else:
            joint_force = -case["damping_nm_s_rad"] * slosh_rate
        in_body = turn(angle).T @ velocity
        q = np.concatenate([position, [angle], slosh])
        v = np.concatenate([[rate], in_body, slosh_rate])
        tau = np.concatenate([[case["torque_nm"]], case["force_body_n"], joint_force])
        theirs = engine.evaluate(q, v, tau, np.zeros(len(v)))["forward"]
        # Theirs is the derivative of the body components of the velocity.
        ours = np.concatenate([[angular], hub - rate * QUARTER_TURN @ in_body, slosh_acceleration])
        name = f"planar tank {case['name']}"
        table.compare(name, "newton", "pinocchio", "accelerations", ours, theirs, BOUND_ACCELERATION)


def case_document(raw, table):
    case = numbers(raw)
    name, count = f"planar tank {raw['name']}", len(raw["initial"]["slosh"])
    times, start, rows = integrate(case, np.inf)
    _, _, finer = integrate(case, 0.02)
    for column, label in zip(rows.T, column_names(count)):
        fine = finer[:, column_names(count).index(label)]
        table.compare(name, "newton", "newton, 0.02 s", "trajectory", column, fine, BOUND_TRAJECTORY)
    gained = np.array([energy(case, x, count) for x in rows]) - energy(case, start, count)
    table.compare(name, "newton", "newton", "energy - work", gained, rows[:, -1], BOUND_TRAJECTORY)
    check_with_joints(case, rows, table)
    return {**raw, "states": [state_document(case, t, x) for t, x in zip(times, rows)]}


def column_names(count):
    slosh = [f"slosh_{number}" for number in range(count)]
    return ["x", "y", "angle", *slosh, "v_x", "v_y", "rate", *(f"{name}_rate" for name in slosh), "work"]


def document(table):
    return {
        "format": "obsid golden planar_tank 1",
        "generated_by": "tests/peers/run dynamics --write (planar_tank.py)",
        "generator_sha256": golden.source_sha256(SOURCES),
        "engines": {"numpy": np.__version__, "scipy": scipy.__version__},
        "integrator": f"DOP853 rtol {RTOL} atol {ATOL}",
        "conventions": DERIVATION,
        "cases": [case_document(case, table) for case in (SPRINGS, PENDULUM)],
    }


def compare_with_golden(fresh, committed, table):
    for new, old in zip(golden.plain(fresh)["cases"], committed["cases"], strict=True):
        for key in new["states"][0]:
            a, b = ([state[key] for state in case["states"]] for case in (old, new))
            table.compare(f"planar tank {new['name']}", "golden", "newton", "states", a, b, BOUND_TRAJECTORY)
