"""Pinocchio on our conventions: ABA, RNEA, CRBA, joint torque regressor, energies, centroidal momentum.

What is converted: the free joint's q (quaternion last in Pinocchio, w first here) and v (linear first there, angular
first here), the planar joint's q ([x, y, cos, sin] there) and v ([vx, vy, wz] there); both have the same meaning in
both, components in body axes, so it is a permutation. Pinocchio numbers joints depth-first; a body on a fixed joint has
no joint there: its mass is added to the next moving body below, and its columns of the regressor are that body's
columns times the 10 x 10 map that moves inertial parameters between frames.
"""

import numpy as np
import pinocchio as pin

# Pinocchio's velocity entry for each of ours.
FREE_SPATIAL = [3, 4, 5, 0, 1, 2]
FREE_PLANAR = [2, 0, 1]


class Pinocchio:
    name = "pinocchio"
    version = pin.__version__

    def __init__(self, system):
        self.system = system
        self.model = pin.Model()
        self.model.gravity = pin.Motion(np.asarray(system.gravity_m_s2), np.zeros(3))
        # Of every body: its joint in Pinocchio (0 is the world) and its pose in that joint's frame.
        self.joint_of = [0] * len(system.bodies)
        self.pose_in_joint = [pin.SE3.Identity()] * len(system.bodies)
        for index in system.depth_first():
            self._add(index)
        self.data = self.model.createData()
        self.to_theirs = self._velocity_permutation()

    def _add(self, index):
        body = self.system.bodies[index]
        below = self.joint_of[body.parent] if body.parent >= 0 else 0
        pose_below = self.pose_in_joint[body.parent] if body.parent >= 0 else pin.SE3.Identity()
        pose = pose_below * pin.SE3(body.rotation, body.position_m)
        if body.joint == "fixed":
            self.joint_of[index], self.pose_in_joint[index] = below, pose
        else:
            joint = {
                "free_spatial": pin.JointModelFreeFlyer,
                "free_planar": pin.JointModelPlanar,
                "revolute": lambda: pin.JointModelRevoluteUnaligned(body.axis),
                "prismatic": lambda: pin.JointModelPrismaticUnaligned(body.axis),
            }[body.joint]()
            self.joint_of[index] = self.model.addJoint(below, joint, pose, body.name)
        inertia = pin.Inertia(body.mass_kg, body.com_m, body.inertia_com_kg_m2)
        self.model.appendBodyToJoint(self.joint_of[index], inertia, self.pose_in_joint[index])

    def _velocity_permutation(self):
        theirs = np.zeros(self.system.velocities(), int)
        for body, ours, joint in zip(self.system.bodies, self.system.velocity_slices(), self.joint_of):
            order = {"free_spatial": FREE_SPATIAL, "free_planar": FREE_PLANAR, "fixed": []}.get(body.joint, [0])
            theirs[ours] = [self.model.idx_vs[joint] + entry for entry in order]
        return theirs

    def coordinates(self, q):
        theirs = np.zeros(self.model.nq)
        for body, ours, joint in zip(self.system.bodies, self.system.coordinate_slices(), self.joint_of):
            start, part = self.model.idx_qs[joint], q[ours]
            if body.joint == "free_spatial":
                theirs[start : start + 7] = part[[0, 1, 2, 4, 5, 6, 3]]
            elif body.joint == "free_planar":
                theirs[start : start + 4] = [part[0], part[1], np.cos(part[2]), np.sin(part[2])]
            elif body.joint != "fixed":
                theirs[start] = part[0]
        return theirs

    def rates(self, ours):
        theirs = np.zeros(self.model.nv)
        theirs[self.to_theirs] = ours
        return theirs

    def evaluate(self, q, v, tau, a):
        """Everything a golden state holds."""
        model, data, order = self.model, self.data, self.to_theirs
        their_q, their_v, their_a = self.coordinates(q), self.rates(v), self.rates(a)
        forward = pin.aba(model, data, their_q, their_v, self.rates(tau))[order]
        inverse = pin.rnea(model, data, their_q, their_v, their_a)[order]
        upper = np.triu(pin.crba(model, data, their_q))
        mass_matrix = (upper + np.triu(upper, 1).T)[np.ix_(order, order)]
        regressor = np.array(pin.computeJointTorqueRegressor(model, data, their_q, their_v, their_a))
        kinetic = pin.computeKineticEnergy(model, data, their_q, their_v)
        return {
            "forward": forward,
            "inverse": inverse,
            "mass_matrix": mass_matrix,
            "regressor": self._regressor(regressor[order]),
            "kinetic_energy_j": kinetic,
            **self._momentum(their_q, their_v),
        }

    def _regressor(self, of_joints):
        blocks = []
        for joint, pose in zip(self.joint_of, self.pose_in_joint):
            if joint == 0:
                blocks.append(np.zeros((of_joints.shape[0], 10)))
            else:
                blocks.append(of_joints[:, 10 * (joint - 1) : 10 * joint] @ parameter_map(pose))
        return np.hstack(blocks)

    def _momentum(self, their_q, their_v):
        """Momentum of all bodies; the system's centre of mass counts a body fixed to the world too."""
        momentum = pin.computeCentroidalMomentum(self.model, self.data, their_q, their_v)
        about_origin = momentum.angular + np.cross(self.data.com[0], momentum.linear)
        mass, first_moment = 0.0, np.zeros(3)
        for body, joint, pose in zip(self.system.bodies, self.joint_of, self.pose_in_joint):
            first_moment += body.mass_kg * (self.data.oMi[joint] * pose).act(body.com_m)
            mass += body.mass_kg
        centre = first_moment / mass
        return {
            "potential_energy_j": -float(self.system.gravity_m_s2 @ first_moment),
            "com_world_m": centre,
            "momentum_world": np.concatenate([about_origin, momentum.linear]),
            "momentum_com": about_origin - np.cross(centre, momentum.linear),
        }


def pseudo_inertia(p):
    inertia = np.array([[p[4], p[5], p[7]], [p[5], p[6], p[8]], [p[7], p[8], p[9]]])
    moments = np.zeros((4, 4))
    moments[:3, :3] = np.trace(inertia) / 2 * np.eye(3) - inertia
    moments[:3, 3] = moments[3, :3] = p[1:4]
    moments[3, 3] = p[0]
    return moments


def parameter_map(pose):
    """10 x 10: inertial parameters about a frame at `pose` to the same about the frame that `pose` is given in."""
    columns = []
    for unit in np.eye(10):
        moved = pose.homogeneous @ pseudo_inertia(unit) @ pose.homogeneous.T
        i = np.trace(moved[:3, :3]) * np.eye(3) - moved[:3, :3]
        columns.append([moved[3, 3], *moved[:3, 3], i[0, 0], i[0, 1], i[1, 1], i[0, 2], i[1, 2], i[2, 2]])
    return np.array(columns).T
