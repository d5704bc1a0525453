"""The agents of the arm and the platform, their laws, and the paths they are led along."""
