"""Descriptions of robots for tests."""

from __future__ import annotations

ALL = """
<robot name="all">
  <link name="base"/> <link name="a"/> <link name="b"/> <link name="c"/> <link name="d"/> <link name="e"/>
  <link name="f"/> <link name="g"/> <link name="h"/> <link name="i"/>
  <joint name="turn" type="revolute">
    <parent link="base"/><child link="a"/><origin xyz="1 2 3" rpy="0.1 0.2 0.3"/><axis xyz="0 2 1"/>
    <limit lower="-1" upper="2" effort="1" velocity="1"/>
  </joint>
  <joint name="wheel" type="continuous"><parent link="a"/><child link="b"/><origin xyz="0 0 1"/></joint>
  <joint name="lift" type="prismatic">
    <parent link="b"/><child link="c"/><axis xyz="3 0 4"/><limit lower="0.5" upper="1" effort="1" velocity="1"/>
  </joint>
  <joint name="plate" type="fixed"><parent link="c"/><child link="d"/><origin rpy="0 0 1.5"/></joint>
  <joint name="fly" type="floating"><parent link="base"/><child link="e"/></joint>
  <joint name="slide" type="planar"><parent link="base"/><child link="f"/><origin xyz="0 5 0"/></joint>
  <joint name="twin" type="revolute">
    <parent link="base"/><child link="g"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/>
    <mimic joint="turn" multiplier="2" offset="0.25"/>
  </joint>
  <joint name="another" type="continuous">
    <parent link="g"/><child link="h"/><axis xyz="0 0 1"/><mimic joint="twin" multiplier="3"/>
  </joint>
  <joint name="soft" type="revolute">
    <parent link="h"/><child link="i"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="1" velocity="1"/>
    <safety_controller soft_lower_limit="0.2" soft_upper_limit="1" k_velocity="1"/>
  </joint>
</robot>
"""


def pair(joint: str) -> str:
    """Return a robot of two links and what is written between them."""
    return f'<robot name="pair"><link name="one"/><link name="two"/>{joint}</robot>'


def joint(inside: str = "", type: str = "continuous", name: str = "j") -> str:
    """Return a joint between the links of `pair`."""
    return f'<joint name="{name}" type="{type}"><parent link="one"/><child link="two"/>{inside}</joint>'
