"""The multibody systems and states that the engines are compared on.

What: random trees of rigid bodies (arms on a fixed and on a free base, planar and spatial, branched, with revolute,
prismatic and fixed joints) and random states of them.
Why: a formulation error hides in symmetric systems; so axes are skew, placements, centres of mass and inertias are
general, and in the branched system the bodies are numbered breadth-first, which neither engine does itself.
How: everything is drawn from named seeded streams. An inertia is made from a positive definite second moment of mass
S as I = tr(S) 1 - S, hence obeys the triangle inequality.

Conventions are those of the golden file; see CONVENTIONS in multibody.py.
"""

import zlib
from dataclasses import dataclass, field

import numpy as np

SEED = 20250301

NUMBER_OF_COORDINATES = {"free_spatial": 7, "free_planar": 3, "fixed": 0, "revolute": 1, "prismatic": 1}
NUMBER_OF_VELOCITIES = {"free_spatial": 6, "free_planar": 3, "fixed": 0, "revolute": 1, "prismatic": 1}


@dataclass
class Body:
    name: str
    parent: int
    joint: str
    axis: np.ndarray
    position_m: np.ndarray
    rotation: np.ndarray
    mass_kg: float
    com_m: np.ndarray
    inertia_com_kg_m2: np.ndarray

    def document(self):
        i = self.inertia_com_kg_m2
        return {
            "name": self.name,
            "parent": self.parent,
            "joint": self.joint,
            "axis": self.axis,
            "position_m": self.position_m,
            "rotation": self.rotation,
            "mass_kg": self.mass_kg,
            "com_m": self.com_m,
            "inertia_com_kg_m2": [i[0, 0], i[0, 1], i[0, 2], i[1, 1], i[1, 2], i[2, 2]],
        }


@dataclass
class System:
    name: str
    gravity_m_s2: np.ndarray
    bodies: list = field(default_factory=list)

    def coordinate_slices(self):
        return self._slices(NUMBER_OF_COORDINATES)

    def velocity_slices(self):
        return self._slices(NUMBER_OF_VELOCITIES)

    def velocities(self):
        return sum(NUMBER_OF_VELOCITIES[body.joint] for body in self.bodies)

    def _slices(self, width):
        ends = np.cumsum([width[body.joint] for body in self.bodies]).tolist()
        return [slice(end - width[body.joint], end) for body, end in zip(self.bodies, ends)]

    def parameters(self):
        """[m, m c (3), Ixx, Ixy, Iyy, Ixz, Iyz, Izz] of every body, the inertia about the body frame's origin."""
        return np.concatenate([dynamic_parameters(b.mass_kg, b.com_m, b.inertia_com_kg_m2) for b in self.bodies])

    def depth_first(self):
        """The bodies' indices, each parent directly followed by its first child's whole branch."""

        def branch(parent):
            for index, body in enumerate(self.bodies):
                if body.parent == parent:
                    yield index
                    yield from branch(index)

        return list(branch(-1))


def skew(c):
    return np.array([[0.0, -c[2], c[1]], [c[2], 0.0, -c[0]], [-c[1], c[0], 0.0]])


def dynamic_parameters(mass_kg, com_m, inertia_com):
    inertia_origin = inertia_com - mass_kg * skew(com_m) @ skew(com_m)
    i = inertia_origin
    first_moment = mass_kg * com_m
    return np.array([mass_kg, *first_moment, i[0, 0], i[0, 1], i[1, 1], i[0, 2], i[1, 2], i[2, 2]])


def quaternion_to_rotation(q):
    w, x, y, z = q
    return np.array(
        [
            [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
        ]
    ) / (w * w + x * x + y * y + z * z)


def rotation_to_quaternion(r):
    """Unit quaternion [w, x, y, z]; the greatest of the four candidates (Shepperd), so nothing cancels."""
    trace = np.trace(r)
    squares = [trace, r[0, 0], r[1, 1], r[2, 2]]
    largest = int(np.argmax(squares))
    if largest == 0:
        q = np.array([1 + trace, r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]])
    else:
        i, j, k = largest - 1, largest % 3, (largest + 1) % 3
        q = np.zeros(4)
        q[0] = r[k, j] - r[j, k]
        q[1 + i] = 1 + r[i, i] - r[j, j] - r[k, k]
        q[1 + j] = r[j, i] + r[i, j]
        q[1 + k] = r[k, i] + r[i, k]
    return q / np.linalg.norm(q)


def stream(*names):
    return np.random.default_rng([SEED, *(zlib.crc32(name.encode()) for name in names)])


def unit_vector(rng, size):
    vector = rng.standard_normal(size)
    return vector / np.linalg.norm(vector)


def random_body(rng, name, parent, joint, scale=1.0):
    """A body of about 10 kg and 0.5 m (times scale) on a joint with a general axis and placement."""
    mass = scale * rng.uniform(4.0, 15.0)
    axes = quaternion_to_rotation(unit_vector(rng, 4))
    second_moment = axes @ np.diag(mass * rng.uniform(0.05, 0.3, 3) ** 2) @ axes.T
    second_moment = (second_moment + second_moment.T) / 2
    is_free = joint.startswith("free")
    return Body(
        name=name,
        parent=parent,
        joint=joint,
        axis=np.array([0.0, 0.0, 1.0]) if is_free or joint == "fixed" else unit_vector(rng, 3),
        position_m=np.zeros(3) if is_free else rng.uniform(-0.6, 0.6, 3),
        rotation=np.eye(3) if is_free else quaternion_to_rotation(unit_vector(rng, 4)),
        mass_kg=mass,
        com_m=rng.uniform(-0.3, 0.3, 3),
        inertia_com_kg_m2=np.trace(second_moment) * np.eye(3) - second_moment,
    )


def make_system(model, gravity_m_s2, joints):
    """joints: (name, parent, joint, scale) of each body. The model's name seeds its bodies, whatever the gravity."""
    rng = stream("bodies", model)
    suffix = "_gravity" if np.any(gravity_m_s2) else ""
    bodies = [random_body(rng, *row) for row in joints]
    return System(model + suffix, np.asarray(gravity_m_s2, float), bodies)


def planar_arm(gravity_m_s2):
    """Base moving in the x-y plane, two joints about z: axes parallel, link frames turned about z only."""
    rows = [("base", -1, "free_planar", 8.0), ("link_1", 0, "revolute", 1.0), ("link_2", 1, "revolute", 0.7)]
    system = make_system("planar_free_arm_2_joints", gravity_m_s2, rows)
    rng = stream("planar placements")
    for body in system.bodies[1:]:
        angle = rng.uniform(-np.pi, np.pi)
        body.axis = np.array([0.0, 0.0, 1.0])
        body.rotation = quaternion_to_rotation([np.cos(angle / 2), 0.0, 0.0, np.sin(angle / 2)])
    return system


def arm(base, number_of_joints):
    rows = [("base", -1, "free_spatial", 10.0)] if base == "free" else []
    for number in range(1, number_of_joints + 1):
        rows.append((f"link_{number}", len(rows) - 1, "revolute", 1.5 / number**0.5))
    return rows


BRANCHED = [
    ("hub", -1, "free_spatial", 10.0),
    ("boom", 0, "revolute", 1.0),
    ("mast", 0, "prismatic", 1.0),
    ("box", 0, "fixed", 2.0),
    ("boom_tip", 1, "revolute", 0.5),
    ("mast_tip", 2, "fixed", 0.5),
    ("box_panel", 3, "revolute", 0.5),
    ("mast_antenna", 5, "revolute", 0.2),
]
RIG = [
    ("pillar", -1, "fixed", 5.0),
    ("carriage", 0, "prismatic", 3.0),
    ("trolley", 1, "prismatic", 2.0),
    ("turret", 2, "revolute", 1.0),
    ("adapter", 3, "fixed", 0.4),
    ("plunger", 4, "prismatic", 0.5),
]


def systems():
    none, down, tilted = [0.0, 0.0, 0.0], [0.0, 0.0, -9.81], [1.1, -2.3, -9.2]
    return [
        make_system("fixed_base_arm_2_joints", none, arm("fixed", 2)),
        make_system("fixed_base_arm_2_joints", down, arm("fixed", 2)),
        make_system("fixed_base_arm_6_joints", none, arm("fixed", 6)),
        make_system("fixed_base_arm_6_joints", tilted, arm("fixed", 6)),
        make_system("free_floating_arm_2_joints", none, arm("free", 2)),
        make_system("free_floating_arm_2_joints", tilted, arm("free", 2)),
        make_system("free_floating_arm_6_joints", none, arm("free", 6)),
        make_system("free_floating_arm_6_joints", down, arm("free", 6)),
        planar_arm(none),
        planar_arm([0.4, -1.6, -3.0]),
        make_system("branched_free_floating", none, BRANCHED),
        make_system("branched_free_floating", tilted, BRANCHED),
        make_system("prismatic_rig_on_fixed_pillar", tilted, RIG),
    ]


def random_states(system, purpose, count):
    """(q, v, tau, a) of `count` states."""
    rng = stream("states", system.name, purpose)
    return [
        (
            random_coordinates(rng, system),
            random_rates(rng, system, 0.8),
            random_rates(rng, system, 4.0),
            random_rates(rng, system, 2.0),
        )
        for _ in range(count)
    ]


def random_coordinates(rng, system):
    parts = []
    for body in system.bodies:
        if body.joint == "free_spatial":
            parts += [rng.uniform(-2.0, 2.0, 3), unit_vector(rng, 4)]
        elif body.joint == "free_planar":
            parts.append(rng.uniform(-2.0, 2.0, 3))
        elif body.joint == "revolute":
            parts.append(rng.uniform(-np.pi, np.pi, 1))
        elif body.joint == "prismatic":
            parts.append(rng.uniform(-0.5, 0.5, 1))
    return np.concatenate(parts)


def random_rates(rng, system, deviation):
    return deviation * rng.standard_normal(system.velocities())
