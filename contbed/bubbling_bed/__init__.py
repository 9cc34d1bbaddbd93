"""The steady bubbling bed along its height: scene, plan, problem, results."""
