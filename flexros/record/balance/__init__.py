"""Torque balance: torques that acted against inverse-dynamics torques of the nominal robot."""
