"""The arm in a browser: motion from a log, from models of it or from topics, drawn with viser.

* `motion`: what moves: arm coordinates over time, of the robot and of models beside it; needs no viewer.
* `signals`: series beside the scene, on the same axis of time.
* `drawing`: shapes of the arm and ribbons of path errors, as points and faces.
* `scene`, `player`: the page: arms, paths, sliders, playback (viser, extra `view`).
* `shown`: what is to be seen: a log, a robot or a diagnosis.
"""
