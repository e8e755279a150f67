"""The files of a log: which there are, their description, and the reader for each storage."""
