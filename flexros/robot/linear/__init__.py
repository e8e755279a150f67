"""The robot linearised at rest: poles, zeros, frequency responses."""
