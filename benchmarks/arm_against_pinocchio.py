"""Compare `scara_iso.robot.arm` with Pinocchio, a rigid-body library: ``pip install pin`` and run.

Prints the largest difference over random arms and joints. A development check, not a test: the
library brings half a gigabyte, so the tests hold the arm against products of transforms instead.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from scara_iso.robot.arm import Arm, Elbow


def build(arm: Arm) -> pin.Model:
    """Return the arm as a chain of joints about z, z, along z and about z."""
    model, parent = pin.Model(), 0
    offsets = [(0, 0, 0), (arm.link_1_mm, 0, 0), (arm.link_2_mm, 0, 0), (0, 0, 0)]
    kinds = [pin.JointModelRZ(), pin.JointModelRZ(), pin.JointModelPZ(), pin.JointModelRZ()]
    for k, (kind, offset) in enumerate(zip(kinds, offsets, strict=True)):
        place = pin.SE3(np.eye(3), np.array(offset, dtype=float))
        parent = model.addJoint(parent, kind, place, f"joint {k + 1}")
    return model


def main() -> None:
    """Print the largest differences in position [mm], Jacobian [mm/rad] and inverse [deg]."""
    rng, worst = np.random.default_rng(1), np.zeros(3)
    for _ in range(1000):
        arm = Arm(*rng.uniform(100, 800, 2), quill_mm=(0, 200), joint_4_deg=(-720, 720))
        model = build(arm)
        data = model.createData()
        joints = rng.uniform((-179, 1, 0, -179), (179, 179, 200, 179))
        q = np.radians(joints)
        q[2] = joints[2]
        pin.forwardKinematics(model, data, q)
        frame = pin.LOCAL_WORLD_ALIGNED
        slopes = pin.computeJointJacobians(model, data, q)
        slopes = pin.getJointJacobian(model, data, 4, frame)[[0, 1, 2, 5]]
        place, pose = data.oMi[4], arm.forward(joints)
        turn = np.exp(1j * np.radians(pose[3])) - complex(*place.rotation[:2, 0])
        again = arm.inverse([*place.translation, pose[3]], elbow=Elbow.RIGHT)
        worst = np.maximum(worst, [
            max(np.abs(place.translation - pose[:3]).max(), abs(turn)),
            np.abs(slopes - arm.jacobian(joints)).max(),
            np.abs(again[:3] - joints[:3]).max(),
        ])  # fmt: skip
    names = ("position [mm]", "Jacobian [mm/rad]", "inverse [deg, mm]")
    print(f"Pinocchio {pin.__version__}, 1000 random arms and joints, largest difference")
    for name, value in zip(names, worst, strict=True):
        print(f"  {name:18} {value:.1e}")


if __name__ == "__main__":
    main()
