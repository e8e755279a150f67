"""Plants in time: robot, disturbances and noise, alone or in the closed loop, one run or many."""
