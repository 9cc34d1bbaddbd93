"""The steady bubbling bed: its scene, plan, problem and findings."""
