"""Torque that acted against torque that the nominal robot needs."""
