"""A machine at one position: results of its models, joints that reach a pose, stiffness at a frame."""
