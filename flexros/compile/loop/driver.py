"""LLVM text of the closed loop: Runge-Kutta step, the two halves of a sample, and the run over many samples.

The halves `measure` and `advance` are the same functions in a run of a million samples and in a node that steps sample
by sample, so both yield the same bits.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from flexros.compile.ir_text import IrBlock, element, element_wise, set_element
from flexros.compile.loop.divergence import stop_when_diverged
from flexros.compile.loop.runge_kutta import step_weights

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.compile.command_delay import CommandDelay, MotorDelays, TorquePiece
    from flexros.compile.loop.functions import LoopSizes

_STEP_PARAMETERS = ", ".join(f"ptr noalias %{name}" for name in ("x", "u", "w", "p", "weights"))
MEASURE = "loop.measure"
ADVANCE = "loop.advance"
RUN = "loop.run"
JOB_FIELDS = (
    "samples", "plant", "controller", "line", "parameters", "gains",
    "reference", "reference_stride", "reference_shared",
    "noise", "noise_stride", "noise_shared",
    "disturbance", "disturbance_stride", "disturbance_shared",
    "measured", "command", "tool_pose", "states", "diverged",
)  # fmt: skip
"""Entries of the job of `loop.run`, 64 bits each: numbers, addresses (0: not recorded), strides in doubles, flags."""


@dataclass(frozen=True)
class LoopSymbols:
    """Functions of the module that the driver calls; None where the loop has no such stage.

    The step is either `merged_step` (x, u, w, p, weights) -> x, or made here from `derivative`.
    """

    derivative: str | None
    merged_step: str | None
    encoder: str
    tool_pose: str
    controller: str
    sensor: str | None
    exact_update: str | None
    before_step: str | None = None
    after_step: str | None = None
    further: str | None = None


@dataclass(frozen=True)
class LoopDriver:
    """Parameters of the driver text.

    Attributes:
        symbols: Functions to call.
        sizes: Numbers of elements.
        delay: Parts of a sample and remembered commands.
        substeps: Runge-Kutta steps per part.
        lanes: Doubles per number.
    """

    symbols: LoopSymbols
    sizes: LoopSizes
    delay: CommandDelay | MotorDelays
    substeps: int
    lanes: int

    def text(self) -> str:
        """Return the definitions of RUN, MEASURE and ADVANCE."""
        step = self._runge_kutta() if self.symbols.merged_step is None else self._step()
        return "\n".join([step, self._measure(), self._advance(), self._run()])

    def _scratch(self, block: IrBlock, elements: int) -> str:
        return block.value(f"alloca double, i64 {max(1, elements * self.lanes)}, align 64")

    def _copy(self, block: IrBlock, target: str, source: str, elements: int) -> None:
        if elements:
            size = 8 * elements * self.lanes
            block.emit(f"call void @llvm.memcpy.p0.p0.i64(ptr {target}, ptr {source}, i64 {size}, i1 false)")

    def _step(self) -> str:
        """Write the replacement of x by the state one step later; w, u, p and the weights [h, h/2, h/6] are held."""
        block = IrBlock(self.lanes)
        after = self._scratch(block, self.sizes.state)
        block.emit(f"call void @{self.symbols.merged_step}(ptr %x, ptr %u, ptr %w, ptr %p, ptr %weights, ptr {after})")
        for k in range(self.sizes.state):
            block.store(block.load(after, k), "%x", k)
        return _definition(f"internal void @loop.step({_STEP_PARAMETERS})", block)

    def _runge_kutta(self) -> str:
        """Write the same with four calls of the derivative; the formula is that of runge_kutta.py."""
        block = IrBlock(self.lanes)
        n = self.sizes.state
        stage, slope, total = (self._scratch(block, n) for _ in range(3))
        count = n * self.lanes

        def derivative(x: str) -> None:
            block.emit(f"call void @{self.symbols.derivative}(ptr {x}, ptr %u, ptr %w, ptr %p, ptr {slope})")

        h, half, sixth = (block.of_lanes(1).load("%weights", k * self.lanes) for k in range(3))

        def prepare(step: str, weight: int) -> Callable[[IrBlock, str], None]:
            def body(part: IrBlock, i: str) -> None:
                k = element(part, slope, i)
                set_element(part, part.add(element(part, "%x", i), part.mul(part.splat(step), k)), stage, i)
                if weight == 2:
                    k = part.add(element(part, total, i), part.add(k, k))
                set_element(part, k, total, i)

            return body

        def finish(part: IrBlock, i: str) -> None:
            sum_of_slopes = part.add(element(part, total, i), element(part, slope, i))
            step = part.mul(part.splat(sixth), sum_of_slopes)
            set_element(part, part.add(element(part, "%x", i), step), "%x", i)

        derivative("%x")
        for step, weight in ((half, 1), (half, 2), (h, 2)):
            element_wise(block, count, prepare(step, weight))
            derivative(stage)
        element_wise(block, count, finish)
        return _definition(f"internal void @loop.step({_STEP_PARAMETERS})", block)

    def _measure(self) -> str:
        """Write y = [sensor(encoder(x) + noise), further + noise], and the tool pose if its address is not null."""
        block = IrBlock(self.lanes)
        motors = self.sizes.motors
        clean = self._scratch(block, motors) if self.symbols.sensor else "%y"
        block.emit(f"call void @{self.symbols.encoder}(ptr %x, ptr {clean})")
        if self.symbols.further:
            further, noise = block.pointer("%y", motors), block.pointer("%noise", motors)
            block.emit(f"call void @{self.symbols.further}(ptr %x, ptr %p, ptr {further})")

            def add_further_noise(part: IrBlock, i: str) -> None:
                set_element(part, part.add(element(part, further, i), element(part, noise, i)), further, i)

            element_wise(block, self.sizes.further * self.lanes, add_further_noise)

        def add_noise(part: IrBlock, i: str) -> None:
            set_element(part, part.add(element(part, clean, i), element(part, "%noise", i)), clean, i)

        element_wise(block, motors * self.lanes, add_noise)
        if self.symbols.sensor:
            block.emit(f"call void @{self.symbols.sensor}(ptr {clean}, ptr %x, ptr %p, ptr %y)")
        with block.when(block.value("icmp ne ptr %pose, null")):
            block.emit(f"call void @{self.symbols.tool_pose}(ptr %x, ptr %p, ptr %pose)")
        parameters = ", ".join(f"ptr noalias %{name}" for name in ("x", "noise", "p", "y", "pose"))
        return _definition(f"void @{MEASURE}({parameters})", block)

    def _advance(self) -> str:
        """Write the plant from t_k to t_k+1 with the delayed command of t_k and the disturbance."""
        block = IrBlock(self.lanes)
        motors = self.sizes.motors
        torque, weights, after = (self._scratch(block, n) for n in (motors, 3, self.sizes.state))
        wrench = block.pointer("%d", motors)
        for piece in self.delay.torque_pieces(motors):
            self._acting_torque(block, piece, torque)
            h = piece.duration / self.substeps
            for k, weight in enumerate(step_weights(h)):
                block.store(block.number(weight), weights, k)
            half = block.pointer(weights, 1)
            with block.loop(0, self.substeps):
                self._update(block, self.symbols.before_step, torque, wrench, weights, after)
                self._update(block, self.symbols.exact_update, torque, wrench, half, after)
                block.emit(f"call void @loop.step(ptr %x, ptr {torque}, ptr {wrench}, ptr %p, ptr {weights})")
                self._update(block, self.symbols.exact_update, torque, wrench, half, after)
                self._update(block, self.symbols.after_step, torque, wrench, weights, after)
        self._remember(block)
        parameters = ", ".join(f"ptr noalias %{name}" for name in ("x", "line", "u", "d", "p"))
        return _definition(f"void @{ADVANCE}({parameters})", block)

    def _acting_torque(self, block: IrBlock, piece: TorquePiece, torque: str) -> None:
        """Write the command of each motor that acts in this part of the sample, plus disturbance, into `torque`."""
        motors = self.sizes.motors

        def of_age(age: int) -> str:
            return "%u" if age == 0 else block.pointer("%line", (age - 1) * motors)

        if len(set(piece.ages)) > 1:
            for motor, age in enumerate(piece.ages):
                acting = block.add(block.load(of_age(age), motor), block.load("%d", motor))
                block.store(acting, torque, motor)
            return
        source = of_age(piece.ages[0])

        def add_disturbance(part: IrBlock, i: str) -> None:
            set_element(part, part.add(element(part, source, i), element(part, "%d", i)), torque, i)

        element_wise(block, motors * self.lanes, add_disturbance)

    def _update(self, block: IrBlock, symbol: str | None, torque: str, wrench: str, duration: str, after: str) -> None:
        """Replace x by the value of an update function, if the loop has it."""
        if symbol is None:
            return
        block.emit(f"call void @{symbol}(ptr %x, ptr {torque}, ptr {wrench}, ptr %p, ptr {duration}, ptr {after})")
        self._copy(block, "%x", after, self.sizes.state)

    def _remember(self, block: IrBlock) -> None:
        """Shift the line of past commands and insert the new one at its front."""
        length, row = self.delay.line_length, 8 * self.sizes.motors * self.lanes
        if length > 1:
            target = block.pointer("%line", self.sizes.motors)
            size = (length - 1) * row
            block.emit(f"call void @llvm.memmove.p0.p0.i64(ptr {target}, ptr %line, i64 {size}, i1 false)")
        if length > 0:
            self._copy(block, "%line", "%u", self.sizes.motors)

    def _run(self) -> str:
        """Write `i64 run(job)`, which returns the number of samples; it ends early once every lane has diverged."""
        block = IrBlock(self.lanes)
        sizes = self.sizes
        job = {name: self._job_entry(block, k) for k, name in enumerate(JOB_FIELDS)}
        next_controller = self._scratch(block, sizes.controller)
        widths = {"reference": sizes.reference, "noise": sizes.measured, "disturbance": sizes.disturbance}
        buffers = {name: self._scratch(block, width) for name, width in widths.items()}
        with block.loop(0, job["samples"]) as k:
            signals = {name: self._signal(block, job, name, k.index, buffers[name], widths[name]) for name in widths}
            y = self._row(block, job["measured"], k.index, sizes.measured)
            u = self._row(block, job["command"], k.index, sizes.motors)
            pose = self._row(block, job["tool_pose"], k.index, sizes.pose)
            wanted = block.value(f"icmp ne ptr {job['tool_pose']}, null")
            pose = block.value(f"select i1 {wanted}, ptr {pose}, ptr null")
            x, c = job["plant"], job["controller"]
            p, g = job["parameters"], job["gains"]
            block.emit(f"call void @{MEASURE}(ptr {x}, ptr {signals['noise']}, ptr {p}, ptr {y}, ptr {pose})")
            arguments = ", ".join(f"ptr {a}" for a in (c, signals["reference"], y, g, u, next_controller))
            block.emit(f"call void @{self.symbols.controller}({arguments})")
            self._copy(block, c, next_controller, sizes.controller)
            with block.when(block.value(f"icmp ne ptr {job['states']}, null")):
                self._copy(block, self._row(block, job["states"], k.index, sizes.state), x, sizes.state)
            line, d = job["line"], signals["disturbance"]
            block.emit(f"call void @{ADVANCE}(ptr {x}, ptr {line}, ptr {u}, ptr {d}, ptr {p})")
            stop_when_diverged(block, sizes.state, x, job["diverged"], k.index)
        return _definition(f"i64 @{RUN}(ptr %job)", block, last=f"ret i64 {job['samples']}")

    def _job_entry(self, block: IrBlock, k: int) -> str:
        is_number = JOB_FIELDS[k].endswith(("samples", "stride", "shared"))
        return block.value(f"load {'i64' if is_number else 'ptr'}, ptr {block.pointer('%job', k, 'i64')}, align 8")

    def _row(self, block: IrBlock, base: str, k: str, width: int) -> str:
        return block.pointer(base, block.value(f"mul nsw i64 {k}, {width * self.lanes}"), "double")

    def _signal(self, block: IrBlock, job: dict[str, str], name: str, k: str, buffer: str, width: int) -> str:
        """Return the address of a signal at sample k; a signal shared by all lanes is copied to each in the buffer."""
        offset = block.value(f"mul nsw i64 {k}, {job[f'{name}_stride']}")
        row = block.pointer(job[name], offset, "double")
        if self.lanes == 1:
            return row
        shared = block.value(f"icmp ne i64 {job[f'{name}_shared']}, 0")
        with block.when(shared), block.loop(0, width) as i:
            number = block.of_lanes(1).load(row, i.index)
            block.store(block.splat(number), buffer, i.index)
        return block.value(f"select i1 {shared}, ptr {buffer}, ptr {row}")


def _definition(head: str, block: IrBlock, last: str = "ret void") -> str:
    return f"define {head} nounwind {{\nentry:\n{block.text()}\n  {last}\n}}"
