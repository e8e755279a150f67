"""Effects of the position loop of a motor."""

from flexros.effects.servos.servo_command_lag import ServoCommandLag
from flexros.effects.servos.servo_damping_error import ServoDampingError
from flexros.effects.servos.servo_feedforward_error import ServoFeedforwardError
from flexros.effects.servos.servo_integral import ServoIntegral
from flexros.effects.servos.servo_stiffness_error import ServoStiffnessError

__all__ = ["ServoCommandLag", "ServoDampingError", "ServoFeedforwardError", "ServoIntegral", "ServoStiffnessError"]
