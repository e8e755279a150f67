"""The lifecycle service of a node, made to refuse what the state does not allow.

rclpy raises out of the service in that case, which ends the whole node: a transition asked for twice, as happens when
an answer is lost, or by a user's second `ros2 lifecycle set`, must not do that.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rclpy.impl.implementation_singleton import rclpy_implementation

if TYPE_CHECKING:
    from lifecycle_msgs.srv import ChangeState
    from rclpy.lifecycle import LifecycleNode


def refuse_impossible_transitions(node: LifecycleNode) -> None:
    """Answer requests for a transition that is not possible now with `success = false`.

    Args:
        node: The node, before it is given to an executor.
    """
    service = next(service for service in node.services if service.srv_name.endswith("/change_state"))
    change = service.callback

    def answer(request: ChangeState.Request, response: ChangeState.Response) -> ChangeState.Response:
        try:
            return change(request, response)
        except rclpy_implementation.RCLError as error:
            node.get_logger().warning(f"refused a transition: {error}")
            response.success = False
            return response

    service.callback = answer
