"""Models of robots for tests, as URDF."""

from pathlib import Path

INERTIA = '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1.5"/>'

CRATE = f"""<robot name="crate">
  <link name="chassis">
    <inertial><mass value="40"/>{INERTIA}</inertial>
    <visual><geometry><box size="0.6 0.4 0.3"/></geometry></visual>
    <collision><geometry><box size="0.6 0.4 0.3"/></geometry></collision>
  </link>
  <link name="mast">
    <inertial><mass value="2"/>{INERTIA}</inertial>
  </link>
  <link name="arm">
    <inertial>
      <origin xyz="0.3 0 0"/><mass value="2"/>{INERTIA}
    </inertial>
  </link>
  <joint name="mast_joint" type="fixed">
    <parent link="chassis"/><child link="mast"/><origin xyz="0.1 0 0.2"/>
  </joint>
  <joint name="shoulder" type="revolute">
    <parent link="mast"/><child link="arm"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" effort="100" velocity="3"/>
  </joint>
  <transmission name="shoulder_motor">
    <type>transmission_interface/SimpleTransmission</type>
    <joint name="shoulder"/><actuator name="shoulder_motor"/>
  </transmission>
</robot>
"""

# The same chassis on motors of its own.
STAGES = f"""<robot name="stages">
  <link name="world"/>
  <link name="x"/>
  <link name="y"/>
  <link name="chassis">
    <inertial><mass value="40"/>{INERTIA}</inertial>
    <collision><geometry><box size="0.6 0.4 0.3"/></geometry></collision>
  </link>
  <joint name="along_x" type="prismatic">
    <parent link="world"/><child link="x"/><axis xyz="1 0 0"/>
    <origin xyz="0 0 0.2"/>
    <limit lower="-50" upper="50" effort="200" velocity="3"/>
  </joint>
  <joint name="along_y" type="prismatic">
    <parent link="x"/><child link="y"/><axis xyz="0 1 0"/>
    <limit lower="-50" upper="50" effort="200" velocity="3"/>
  </joint>
  <joint name="turn" type="continuous">
    <parent link="y"/><child link="chassis"/><axis xyz="0 0 1"/>
  </joint>
</robot>
"""

WITHOUT_MASS = """<robot name="feather">
  <link name="chassis"/>
</robot>
"""


def write_model(folder: Path, text: str) -> str:
    """Writes a model to a file, and returns its path."""
    file = folder / "robot.urdf"
    file.write_text(text)
    return str(file)
