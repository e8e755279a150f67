"""Report pages: sections, blocks, pictures, number text; one HTML file that opens offline."""
