// Prints the seconds of a step of lightsfm: people from standard input, as
// their number, the number of steps, and rows (x, y, vx, vy).
#include <chrono>
#include <iostream>
#include "sfm.hpp"

int main() {
  unsigned people, steps;
  std::cin >> people >> steps;
  std::vector<sfm::Agent> agents(people);
  for (unsigned i = 0; i < people; ++i) {
    double x, y, vx, vy;
    std::cin >> x >> y >> vx >> vy;
    sfm::Agent &agent = agents[i];
    agent.id = i;
    agent.position.set(x, y);
    agent.velocity.set(vx, vy);
    agent.linearVelocity = std::hypot(vx, vy);
    agent.desiredVelocity = 1.4;
    sfm::Goal goal;
    goal.center.set(x + 50 * vx, y + 50 * vy);
    goal.radius = 0.3;
    agent.goals.push_back(goal);
  }
  const auto start = std::chrono::steady_clock::now();
  for (unsigned k = 0; k < steps; ++k) {
    sfm::SFM.computeForces(agents);
    sfm::SFM.updatePosition(agents, 0.05);
  }
  const std::chrono::duration<double> taken =
      std::chrono::steady_clock::now() - start;
  // (The sum is printed so that no compiler leaves the steps out.)
  double sum = 0;
  for (const sfm::Agent &agent : agents) sum += agent.position.getX();
  std::cout << taken.count() / steps << " " << sum << std::endl;
}
