"""An MJCF with most of what an import resolves: classes, Euler angles, geoms by density, servos, a spring."""

ARM = """<!-- an arm of five motors -->
<mujoco model="arm">
  <compiler angle="degree" autolimits="true" eulerseq="zyx"/>
  <option timestep="0.001" gravity="0 0 -9.81"/>
  <default>
    <joint damping="1.5" armature="0.05"/>
    <geom density="2700"/>
    <default class="wrist"><joint damping="0.2" armature="0.01" frictionloss="0.4"/></default>
  </default>
  <worldbody>
    <geom type="plane" size="1 1 .1"/>
    <body name="pedestal" pos="0.1 0.2 0" euler="90 0 0">
      <geom type="cylinder" size=".1 .2"/>
      <body name="shoulder" pos="0 0 0.3">
        <joint name="j1" axis="0 0 1"
               frictionloss="2"/>  <!-- measured -->
        <geom type="capsule" fromto="0 0 0 0.1 0.02 0.1" size=".06"/>
        <body name="upper" pos="0.1 0 0.1" euler="0 0 90">
          <joint name="j2" axis="0 0 -1" pos="0.01 0.02 0.03" ref="10"/>
          <geom type="box" size=".05 .06 .3" pos="0 .03 .3" euler="5 10 20"/>
          <body name="fore" pos="0 0 0.6">
            <inertial pos="0.1 0.02 0.05" mass="3" fullinertia="0.05 0.06 0.04 0.001 0.002 0.003"/>
            <joint name="j3" axis="0 0 1"/>
            <joint name="j4" class="wrist" axis="1 0 0" pos="0.3 0 0"/>
            <body name="rail" pos="0.4 0 0" quat="0.5 0.5 0.5 0.5">
              <joint name="s5" type="slide" axis="0 1 0" class="wrist"/>
              <geom size=".05 .02" type="cylinder"/>
              <body name="hand" pos="0 0.1 0">
                <geom type="sphere" size=".04" pos=".01 .02 .03"/>
                <body name="flap" pos="0.05 0 0">
                  <joint name="spring6" axis="0 1 0" stiffness="20" armature="0"/>
                  <geom type="sphere" size=".03" pos="0 .1 0"/>
                </body>
              </body>
            </body>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
  <actuator>
    <motor name="m1" joint="j1" gear="10" ctrlrange="-5 5"/>
    <position name="m2" joint="j2" kp="500" kv="20" forcerange="-80 80"/>
    <motor joint="j3"/>
    <velocity joint="j4" kv="3"/>
    <motor joint="s5"/>
  </actuator>
</mujoco>
"""
