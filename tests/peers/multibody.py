"""Golden numbers for multibody dynamics, from Pinocchio and from MuJoCo.

What: `tests/golden/multibody.json`: systems, states, and what each engine says about them.
Why: `shared/plant` is checked against formulations and code that nobody here wrote.
How: both engines get the same systems (rigid_bodies.py) through their own conventions (pinocchio_engine.py,
mujoco_engine.py). They are first compared with each other on all states: an error in a conversion would have to be made
twice, in two different conventions, to stay hidden. Inside Pinocchio, regressor x parameters must be the inverse
dynamics, and ABA the inverse of RNEA.
"""

import numpy as np

import golden
from mujoco_engine import MuJoCo
from pinocchio_engine import Pinocchio
from rigid_bodies import SEED, random_states, systems

FILE = "multibody.json"
SOURCES = ["multibody.py", "rigid_bodies.py", "pinocchio_engine.py", "mujoco_engine.py"]
STATES_PINOCCHIO, STATES_MUJOCO = 20, 6
# Regressors are nv x 10 nb numbers; of the great ones only the first states are kept.
REGRESSOR_NUMBERS = 2500
# Each quantity of a state, and the row of the table that it counts in.
QUANTITIES = {
    "forward": "forward",
    "inverse": "inverse",
    "mass_matrix": "mass matrix",
    "regressor": "regressor",
    "kinetic_energy_j": "energies",
    "potential_energy_j": "energies",
    "com_world_m": "momenta, com",
    "momentum_world": "momenta, com",
    "momentum_com": "momenta, com",
}
# Two formulations in doubles; the forward dynamics divides by a mass matrix of condition number up to 1e4.
BOUND_ENGINES = 1e-10
# The same engine again: other processors sum in other orders; the potential energy of one rig nearly cancels.
BOUND_GOLDEN = 1e-11

CONVENTIONS = (
    "SI units. Bodies form a tree; parent is an index into bodies, -1 is the world (inertial axes). Each body's frame "
    "sits on its joint: at q = 0 its origin is at position_m in the parent's frame, and rotation (row-major) takes "
    "components in the body's frame to components in the parent's frame. A revolute joint turns the body about axis, "
    "a prismatic joint moves it along axis; axis is a unit vector in the body's (joint's) frame; for free and fixed "
    "joints it has no meaning. com_m, inertia_com_kg_m2 [xx, xy, xz, yy, yz, zz] in body axes, inertia about the "
    "centre of mass, xy being the matrix entry (minus the product of inertia). q, v, tau, accelerations are the "
    "joints' parts in the order of bodies. free_spatial: q = [x, y, z, qw, qx, qy, qz], position of the body's origin "
    "in the world and quaternion body to world; v = [omega (3), velocity of the body's origin (3)], both relative to "
    "the world in body axes; accelerations are the time derivatives of these six components (Featherstone's spatial "
    "acceleration); tau = [torque about the body's origin (3), force (3)] in body axes. free_planar: q = [x, y, "
    "theta], theta about the world's z; v = [omega_z, v_x, v_y] in body axes, derivatives and tau likewise. forward: "
    "accelerations from (q, v, tau). inverse: tau from (q, v, a). Gravity acts in both. mass_matrix: nv x nv "
    "row-major. regressor: nv x 10 nb row-major at (q, v, a), inverse = regressor x parameters, per body in the order "
    "of bodies [m, m c_x, m c_y, m c_z, Ixx, Ixy, Iyy, Ixz, Iyz, Izz] with I about the body frame's origin; null "
    "where the engine has none or to save space. potential_energy_j = -sum m g.r, zero at the world's origin, all "
    "bodies. com_world_m: centre of mass of all bodies, a body fixed to the world included. momentum_world = [angular "
    "about the world's origin (3), linear (3)], momentum_com = angular about com_world_m (3), world axes."
)


def states_kept_with_regressor(system):
    numbers = system.velocities() * 10 * len(system.bodies)
    return max(3, REGRESSOR_NUMBERS // numbers)


def case_document(system, engine_class, count, table):
    engines = {"pinocchio": Pinocchio(system), "mujoco": MuJoCo(system)}
    states = []
    for number, (q, v, tau, a) in enumerate(random_states(system, engine_class.name, count)):
        answers = {name: engine.evaluate(q, v, tau, a) for name, engine in engines.items()}
        compare_engines(system, answers, table)
        check_pinocchio(system, engines["pinocchio"], answers["pinocchio"], (q, v, tau, a), table)
        kept = answers[engine_class.name]
        if number >= states_kept_with_regressor(system):
            kept["regressor"] = None
        states.append({"q": q, "v": v, "tau": tau, "forward": kept["forward"], "a": a, **kept})
    return {
        "name": f"{system.name}_{engine_class.name}",
        "engine": engine_class.name,
        "gravity_m_s2": system.gravity_m_s2,
        "bodies": [body.document() for body in system.bodies],
        "states": states,
    }


def compare_engines(system, answers, table):
    for quantity, row in QUANTITIES.items():
        a, b = answers["pinocchio"][quantity], answers["mujoco"][quantity]
        if a is not None and b is not None:
            table.compare(system.name, "pinocchio", "mujoco", row, a, b, BOUND_ENGINES)


def check_pinocchio(system, engine, answer, state, table):
    q, v, tau, _ = state
    from_regressor = answer["regressor"] @ system.parameters()
    name = system.name
    table.compare(name, "pinocchio", "pinocchio", "regressor x parameters", answer["inverse"], from_regressor, 1e-12)
    back = engine.evaluate(q, v, tau, answer["forward"])["inverse"]
    table.compare(name, "pinocchio", "pinocchio", "inverse of forward", tau, back, BOUND_ENGINES)


def document(table):
    cases = []
    for engine_class, count in [(Pinocchio, STATES_PINOCCHIO), (MuJoCo, STATES_MUJOCO)]:
        cases += [case_document(system, engine_class, count, table) for system in systems()]
    return {
        "format": "obsid golden multibody 1",
        "generated_by": "tests/peers/run dynamics --write (multibody.py)",
        "generator_sha256": golden.source_sha256(SOURCES),
        "engines": {"pinocchio": Pinocchio.version, "mujoco": MuJoCo.version, "numpy": np.__version__},
        "seed": SEED,
        "conventions": CONVENTIONS,
        "cases": cases,
    }


def compare_with_golden(fresh, committed, table):
    """The committed numbers against those just made; a committed case or state that is missing counts as infinite."""
    fresh = golden.plain(fresh)
    if [case["name"] for case in fresh["cases"]] != [case["name"] for case in committed["cases"]]:
        table.add("all", "golden", "fresh", "names of cases", float("inf"), BOUND_GOLDEN)
        return
    for new, old in zip(fresh["cases"], committed["cases"]):
        name, engine = new["name"].removesuffix("_" + new["engine"]), new["engine"]
        same_model = new["bodies"] == old["bodies"] and len(new["states"]) == len(old["states"])
        table.add(name, "golden", engine, "all", 0.0 if same_model else float("inf"), BOUND_GOLDEN)
        for new_state, old_state in zip(new["states"], old["states"]):
            for quantity in QUANTITIES:
                if new_state[quantity] is not None:
                    a, b = old_state[quantity], new_state[quantity]
                    table.compare(name, "golden", engine, "all", [] if a is None else a, b, BOUND_GOLDEN)
