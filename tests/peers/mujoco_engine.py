"""MuJoCo on our conventions: forward and inverse dynamics, mass matrix, energies, momentum.

What is converted: MuJoCo's free joint has the velocity of the body's origin in world axes first, then the angular
velocity in body axes; its acceleration is the derivative of just these. With R the attitude, ours are

    v = [omega; R^T u],    v' = [omega'; R^T u' - omega x R^T u],    their forces = A^T ours,  A = dv/d(their v).

A planar base is two slides along world x and y and a hinge about z; the same formulas hold with omega = [0, 0, theta'].
MuJoCo numbers bodies depth-first. Its compiler reads decimal text and diagonalises inertias to 1e-12 or so; both are
overwritten by full-precision numbers after compiling.
"""

import mujoco
import numpy as np

from rigid_bodies import quaternion_to_rotation, rotation_to_quaternion


def text(numbers):
    return " ".join(repr(float(number)) for number in np.ravel(numbers))


class MuJoCo:
    name = "mujoco"
    version = mujoco.__version__

    def __init__(self, system):
        self.system = system
        self.model = mujoco.MjModel.from_xml_string(self._xml())
        self._set_exact_numbers()
        self.data = mujoco.MjData(self.model)
        # Of every body: the first of its coordinates and velocities in MuJoCo.
        joints = [self.model.joint(f"{body.name}_joint") if body.joint != "fixed" else None for body in system.bodies]
        self.start_q = [0 if joint is None else int(joint.qposadr[0]) for joint in joints]
        self.start_v = [0 if joint is None else int(joint.dofadr[0]) for joint in joints]

    def _xml(self):
        return (
            '<mujoco><compiler angle="radian" inertiafromgeom="false" balanceinertia="false"/>'
            f'<option gravity="{text(self.system.gravity_m_s2)}"><flag energy="enable" contact="disable"/></option>'
            f"<worldbody>{self._branch(-1)}</worldbody></mujoco>"
        )

    def _branch(self, parent):
        return "".join(self._body(i, body) for i, body in enumerate(self.system.bodies) if body.parent == parent)

    def _body(self, index, body):
        i = body.inertia_com_kg_m2
        inertia = [i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2]]
        return (
            f'<body name="{body.name}" pos="{text(body.position_m)}"'
            f' quat="{text(rotation_to_quaternion(body.rotation))}">'
            f'<inertial pos="{text(body.com_m)}" mass="{text(body.mass_kg)}" fullinertia="{text(inertia)}"/>'
            f"{joint_xml(body)}{self._branch(index)}</body>"
        )

    def _set_exact_numbers(self):
        model = self.model
        for body in self.system.bodies:
            index = model.body(body.name).id
            principal, axes = np.linalg.eigh(body.inertia_com_kg_m2)
            if np.linalg.det(axes) < 0.0:
                axes[:, 0] = -axes[:, 0]
            model.body_pos[index] = body.position_m
            model.body_quat[index] = rotation_to_quaternion(body.rotation)
            model.body_mass[index] = body.mass_kg
            model.body_ipos[index] = body.com_m
            model.body_inertia[index] = principal
            model.body_iquat[index] = rotation_to_quaternion(axes)
            if body.joint in ("revolute", "prismatic"):
                model.jnt_axis[model.joint(f"{body.name}_joint").id] = body.axis
        mujoco.mj_setConst(model, mujoco.MjData(model))

    def coordinates(self, q):
        theirs = np.zeros(self.model.nq)
        for body, ours, start in zip(self.system.bodies, self.system.coordinate_slices(), self.start_q):
            theirs[start : start + (ours.stop - ours.start)] = q[ours]
        return theirs

    def velocity_map(self, q, v):
        """(A, b) with ours = A theirs and our acceleration = A their acceleration + b."""
        size = self.system.velocities()
        a, b = np.zeros((size, size)), np.zeros(size)
        parts = zip(
            self.system.bodies, self.system.coordinate_slices(), self.system.velocity_slices(), self.start_v
        )
        for body, at_q, ours, start in parts:
            if body.joint == "free_spatial":
                world_to_body = quaternion_to_rotation(q[at_q][3:]).T
                a[ours.start : ours.start + 3, start + 3 : start + 6] = np.eye(3)
                a[ours.start + 3 : ours.stop, start : start + 3] = world_to_body
                b[ours.start + 3 : ours.stop] = -np.cross(v[ours][:3], v[ours][3:])
            elif body.joint == "free_planar":
                cosine, sine = np.cos(q[at_q][2]), np.sin(q[at_q][2])
                a[ours.start, start + 2] = 1.0
                a[ours.start + 1 : ours.stop, start : start + 2] = [[cosine, sine], [-sine, cosine]]
                omega, v_x, v_y = v[ours]
                b[ours.start + 1 : ours.stop] = [omega * v_y, -omega * v_x]
            elif body.joint != "fixed":
                a[ours.start, start] = 1.0
        return a, b

    def evaluate(self, q, v, tau, acceleration):
        model, data = self.model, self.data
        a, b = self.velocity_map(q, v)
        a_inverse = np.linalg.inv(a)
        mujoco.mj_resetData(model, data)
        data.qpos[:] = self.coordinates(q)
        data.qvel[:] = a_inverse @ v
        data.qfrc_applied[:] = a.T @ tau
        mujoco.mj_forward(model, data)
        forward = a @ data.qacc + b
        theirs = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, theirs)
        mechanical = {
            "kinetic_energy_j": float(data.energy[1]),
            "potential_energy_j": float(data.energy[0]),
            **self._momentum(),
        }
        data.qacc[:] = a_inverse @ (acceleration - b)
        mujoco.mj_inverse(model, data)
        return {
            "forward": forward,
            "inverse": a_inverse.T @ data.qfrc_inverse,
            "mass_matrix": a_inverse.T @ theirs @ a_inverse,
            "regressor": None,
            **mechanical,
        }

    def _momentum(self):
        mujoco.mj_subtreeVel(self.model, self.data)
        linear = self.model.body_subtreemass[0] * self.data.subtree_linvel[0]
        about_com, com = self.data.subtree_angmom[0].copy(), self.data.subtree_com[0].copy()
        return {
            "com_world_m": com,
            "momentum_world": np.concatenate([about_com + np.cross(com, linear), linear]),
            "momentum_com": about_com,
        }


def joint_xml(body):
    name = f"{body.name}_joint"
    if body.joint == "fixed":
        return ""
    if body.joint == "free_spatial":
        return f'<joint name="{name}" type="free"/>'
    if body.joint == "free_planar":
        return (
            f'<joint name="{name}" type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/>'
            '<joint type="hinge" axis="0 0 1"/>'
        )
    kind = {"revolute": "hinge", "prismatic": "slide"}[body.joint]
    return f'<joint name="{name}" type="{kind}" axis="{text(body.axis)}"/>'
