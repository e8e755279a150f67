"""Where the search begins on a real machine."""

from __future__ import annotations

from pydantic import Field

from flexros.config.settings import Settings


class TorqueStartSettings(Settings):
    """What the torques of a real machine show before any prediction: the regression that the search begins with."""

    least_share: float = Field(
        default=0.1,
        ge=0,
        description="contribution of friction, motor inertia or servo stiffness to a torque, over the rest at that "
        "motor, from which it is kept, rms [1] (chosen)",
    )
    most_reduced: float = Field(
        default=0.9,
        gt=0,
        lt=1,
        description="largest share of a nominal rotor inertia or servo stiffness that is taken away [1] (chosen)",
    )
    least_bias: float = Field(
        default=0.5,
        ge=0,
        description="the same for a constant torque [1] (chosen): less may be a wrong weight or uneven friction. 1.5 "
        "to 4 on two arms whose joint torque sensors have offsets, up to 0.3 on a UR10e",
    )
    weight: float = Field(
        default=1.0,
        gt=0,
        description="weight of all errors of the torques over that of all prediction errors [1] (chosen)",
    )
    least_rest: float = Field(
        default=0.1,
        gt=0,
        description="least standard deviation of an error of a torque, over the torque that counts as no gap [1] "
        "(chosen)",
    )
    longest_delay: int = Field(
        default=10, ge=0, description="longest delay of commands or torques that is tried [samples] (chosen)"
    )
    late: float = Field(
        default=0.7,
        gt=0,
        description="fall of the sum over the motors of ln(rest of the torque) by a delay from which torques act late "
        "[1] (chosen): 1.4 and more with delays of 1.5 to 5 samples, 0.03 and less without (development cases)",
    )
    balanced: float = Field(
        default=2.5,
        ge=1,
        description="factor by which a counterbalance lowers what is left at its motor, from which there is one, and "
        "by which a curve over position lowers it further, from which that has no law [1] (chosen)",
    )
    carried: float = Field(
        default=0.5,
        ge=0,
        description="torque of either over the largest of its motor, from which there is one [1] (chosen): "
        "it is built to carry weight. Less is an error of the weight of the arm, as on a robot whose URDF is a third "
        "too light",
    )
    carried_little: float = Field(
        default=0.25,
        ge=0,
        description="torque of a counterbalance over the largest of its motor, from which there is one too where it "
        "takes numbers of the model back within their tolerance [1] (chosen)",
    )
    taken_back: float = Field(
        default=0.3,
        gt=0,
        lt=1,
        description="share of the squared deviations of these numbers that it takes back then [1] (chosen)",
    )
    least_taken_back: float = Field(
        default=60.0,
        ge=0,
        description="sum of their squares that it takes back at least, over their tolerances [1] (chosen): 90 and more "
        "with the spring of a simulated arm, 50 and less on measured arms, where it is an error of their weight",
    )
    least_rotor: float = Field(
        default=0.2,
        ge=0,
        description="inertia of a rotor, over that of the bodies it moves, from which the robot file lacks it in any "
        "case [1] (chosen); less may be in that of the bodies, as for a drive whose one mass is that of all its parts",
    )
    clear_rotor: float = Field(
        default=3.0,
        ge=0,
        description="smaller inertia of a rotor, over its standard deviation with bodies within their tolerance, from "
        "which the robot file lacks it [1] (chosen)",
    )
    least_clear_rotor: float = Field(
        default=0.03,
        ge=0,
        description="the same over that of the bodies it moves [1] (chosen): bodies that are stated without tolerance "
        "are not known better",
    )
    no_body: float = Field(
        default=10.0,
        ge=0,
        description="inertia of a rotor, over that of the bodies it moves, from which the robot file lacks it though "
        "it explains little of the torque [1] (chosen): noise of the torque would throw about bodies that light",
    )
    lightest_load: float = Field(
        default=0.005,
        ge=0,
        description="mass of a load over that of all bodies that move, from which the robot file lacks it [1] (chosen)",
    )
    light_load: float = Field(
        default=0.05,
        ge=0,
        description="the same up to which errors of the bodies within their tolerance must not explain it as well [1] "
        "(chosen)",
    )
    heaviest_load: float = Field(
        default=10.0,
        gt=0,
        description="the same above which it is none [1] (chosen): a regression had made a load of 1424 kg at an "
        "arm of 3.8 kg",
    )
    farthest_load: float = Field(
        default=1.0, gt=0, description="largest distance of a load from the last joint [m] (chosen)"
    )
    explained_by_load: float = Field(
        default=10.0,
        ge=1,
        description="product over the motors of the factors by which a load lowers what is left of their torques, each "
        "no larger than this, from which the robot file lacks it [1] (chosen): 1.6 on a UR10e that carries nothing, "
        "above 1000 on an arm whose tool is 7 % of its mass. So the others are not left with more where one motor has "
        "no torque, as where it is not driven: a load that takes the weight of its body away explains that",
    )
    perhaps_load: float = Field(
        default=2.0,
        ge=1,
        description="the same product, over what another mass of the last body leaves, from which a fit with a load of "
        "a rigid arm is tried [1] (chosen): 2.9 to 8 on simulated arms whose load is not clear otherwise, 1.0 on the "
        "same without one",
    )
    before_bodies: float = Field(
        default=1.5,
        ge=1,
        description="the same product from which a load above `light_load` is missing though it is less than "
        "`explained_by_load`: over what errors of all bodies within their tolerance leave, where those of "
        "`rough_bodies` leave no less either [1] (chosen): 1.6 to 10 on robots that carry a load, 1.02 and less on "
        "five that do not",
    )
    turned: float = Field(
        default=1.5,
        ge=1,
        description="the same product from which the encoder of a motor has another zero, and for each angle by which "
        "the base stands at a slant [1] (chosen): what tells a load from errors of bodies tells a turned weight from "
        "them as well",
    )
    rough_bodies: float = Field(
        default=0.15,
        gt=0,
        description="tolerance of masses, centres of mass and inertias of bodies, relative, where they explain by far "
        "more of the torques than within that of the robot file (`explained_by_load`) [1] (chosen): such files have "
        "rough numbers, or those of another version",
    )
    rough_inertias: float = Field(
        default=1.0,
        gt=0,
        description="tolerance of the inertias of bodies about their centres of mass, relative, with which the rotors "
        "are estimated where it explains more of the torques than that of the robot file, and no less than "
        "`rough_bodies` of all numbers (both by `before_bodies`) [1] (chosen)",
    )
    relieved: float = Field(
        default=1.5,
        ge=1,
        description="factor by which a counterbalance alone lowers what is left at its motor, from which a load is "
        "sought together with it [1] (chosen)",
    )


class ServoStartSettings(Settings):
    """Fits of servos under position commands, from several initial values: the best one begins the search."""

    often_limited: float = Field(
        default=0.01,
        gt=0,
        lt=1,
        description="share of the samples at its torque limit from which a servo counts as one that reaches it [1] "
        "(chosen)",
    )
    friction: float = Field(
        default=0.1,
        gt=0,
        description="initial Coulomb friction of a servo at its limit, over the torque limit [1] (chosen)",
    )
    braking: float = Field(
        default=0.5,
        gt=0,
        description="initial viscous friction of a servo at its limit, at the largest speed, over the torque limit [1] "
        "(chosen): a limited voltage ends the acceleration where the back-EMF reaches it",
    )
    little_friction: float = Field(
        default=0.01,
        gt=0,
        description="initial Coulomb friction of other servos, over the largest one of its range [1] (chosen)",
    )
    little_rotor: float = Field(
        default=0.3,
        gt=0,
        description="initial inertia of a rotor that the robot file leaves out, over that of the bodies it moves [1] "
        "(chosen)",
    )
    little_load: float = Field(
        default=0.5,
        gt=0,
        description="initial mass of a load that the robot file leaves out, over that of the last body [1] (chosen)",
    )
    undamped: float = Field(
        default=-0.85,
        gt=-1,
        lt=0,
        description="relative error of the damping of a loop that hardly brakes, a further initial value for servos at "
        "their limits [1] (chosen)",
    )
    wider: float = Field(
        default=10.0,
        ge=1,
        description="factor by which friction may exceed what the largest nominal torque overcomes, as the gains of a "
        "servo may be wrong by it [1] (chosen)",
    )
    delays: tuple[float, ...] = Field(
        default=(0.25, 1.25, 2.25, 3.25),
        min_length=1,
        description="initial delays [samples] (chosen): between whole ones, at which the prediction has a corner",
    )
    lag: float = Field(
        default=2.0, gt=0, description="initial time constant of a filter of the commands [samples] (chosen)"
    )
    first_iterations: int = Field(
        default=3, ge=1, description="iterations from every start, after which the promising ones go on (chosen)"
    )
    promising: int = Field(default=2, ge=1, description="fits of the same effects that go on, the best ones (chosen)")
    iterations: int = Field(
        default=5, ge=1, description="further iterations, after which the best one of the fits goes on alone (chosen)"
    )
    rough_gain: float = Field(
        default=5.0,
        gt=1,
        description="factor by which the gains of the robot file may differ from those with which servos carry the "
        "weight of the arm before the diagnosis begins with the latter [1] (chosen): half of what is sought, on a "
        "logarithmic scale",
    )
    least_carried: float = Field(
        default=0.5,
        gt=0,
        lt=1,
        description="share of the torque of the bodies that their weight is, and that distance, speed and acceleration "
        "of a servo explain, from which its stiffness counts [1] (chosen)",
    )
