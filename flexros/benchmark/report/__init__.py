"""Report of benchmark results: one HTML page that opens offline."""
