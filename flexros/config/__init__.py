"""Settings and topics as typed, validated objects, and reading of YAML and text files."""
