"""Symbolic graph to machine code, with the CasADi virtual machine as fallback and cross-check."""

from flexros.compile.compiled_function import CompiledFunction, compile_function
from flexros.compile.loop.arrays import LoopInputs, LoopResult, LoopState
from flexros.compile.loop.functions import LoopFunctions
from flexros.compile.loop.kernel import LoopKernel, LoopStepper, compile_loop
from flexros.compile.module_builder import ModuleBuilder

__all__ = [
    "CompiledFunction",
    "LoopFunctions",
    "LoopInputs",
    "LoopKernel",
    "LoopResult",
    "LoopState",
    "LoopStepper",
    "ModuleBuilder",
    "compile_function",
    "compile_loop",
]
