"""Logs of other recorders: files of columns become the topics of the contract by a mapping file."""
