"""Time-optimal motion along a path: as fast as torque and speed limits of the motors allow."""
