"""A file of people as HuNavSim writes them."""

# One person, who walks through the cafe.
AGENTS = """\
hunav_loader:
  ros__parameters:
    map: cafe
    publish_people: true
    agents: [agent1]
    agent1:
      id: 1
      skin: 0
      group_id: -1
      max_vel: 1.5
      radius: 0.4
      behavior:
        type: 1
        configuration: 0
        duration: 40.0
        once: true
        vel: 0.6
        dist: 0.0
        goal_force_factor: 2.0
        obstacle_force_factor: 10.0
        social_force_factor: 5.0
        other_force_factor: 20.0
      init_pose: {x: -3.0, y: 7.0, z: 1.25, h: 0.0}
      goal_radius: 0.3
      cyclic_goals: true
      goals: [g0, g1]
      g0: {x: -3.2, y: 3.3, h: 1.25}
      g1: {x: -3.8, y: -6.2, h: 1.25}
"""
