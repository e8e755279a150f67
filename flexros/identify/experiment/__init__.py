"""Identification experiments: plan, timetable, limits and reference."""
