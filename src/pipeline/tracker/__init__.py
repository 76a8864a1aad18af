"""Maximum power point tracking: what a tracker gets out of a panel, in closed loop through the boost converter."""
