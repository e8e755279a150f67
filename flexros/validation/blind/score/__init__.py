"""Scoring of a blind check: answers against sealed truths."""
