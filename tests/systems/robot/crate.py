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


# As robots of ROS are: an empty root on the floor, the base above it.
FOOTPRINT = f"""<robot name="turtle" xmlns:drake="http://drake.mit.edu">
  <link name="base_footprint"/>
  <link name="base_link">
    <inertial><mass value="12"/>
      <inertia ixx="0.2" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.3"/>
    </inertial>
    <visual><geometry><cylinder radius="0.2" length="0.1"/></geometry></visual>
    <collision>
      <geometry><cylinder radius="0.2" length="0.1"/></geometry>
    </collision>
  </link>
  <joint name="base_joint" type="fixed">
    <parent link="base_footprint"/><child link="base_link"/>
    <origin xyz="0.02 0 0.12"/>
  </joint>
  {
    "".join(
        f'''<link name="{side}_wheel">
    <inertial><mass value="1"/>
      <inertia ixx="0.003" ixy="0" ixz="0" iyy="0.003" iyz="0" izz="0.003"/>
    </inertial>
    <collision><geometry><sphere radius="0.08"/></geometry></collision>
  </link>
  <joint name="{side}_joint" type="continuous">
    <parent link="base_link"/><child link="{side}_wheel"/>
    <origin xyz="-0.02 {y} -0.04"/><axis xyz="0 1 0"/>
  </joint>'''
        for side, y in (("left", 0.15), ("right", -0.15))
    )
}
  {
    "".join(
        f'''<link name="{end}_caster">
    <inertial><mass value="0.2"/>
      <inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-4"/>
    </inertial>
    <collision><geometry><sphere radius="0.02"/></geometry>
      <drake:proximity_properties>
        <drake:mu_static value="0"/><drake:mu_dynamic value="0"/>
      </drake:proximity_properties>
    </collision>
  </link>
  <joint name="{end}_caster_joint" type="fixed">
    <parent link="base_link"/><child link="{end}_caster"/>
    <origin xyz="{x} 0 -0.1"/>
  </joint>'''
        for end, x in (("front", 0.13), ("rear", -0.17))
    )
}
</robot>
"""
