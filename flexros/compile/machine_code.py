"""LLVM text to machine code for the processor it runs on, kept in memory."""

from __future__ import annotations

import ctypes
import ctypes.util
from functools import lru_cache
from importlib.util import find_spec
from threading import Lock

from flexros.compile.operations import LIBRARY_SYMBOLS
from flexros.errors import InputError

_COMPILING = Lock()


def can_compile() -> bool:
    """Return whether llvmlite is installed."""
    return find_spec("llvmlite") is not None


class MachineCode:
    """Compiled functions. They live as long as this object: keep it together with any address."""

    def __init__(self, text: str, level: int = 2) -> None:
        """Compile LLVM text.

        Args:
            text: A complete module.
            level: Optimisation level of the code generator, 0 to 3. The module itself is not optimised: the text is
                already straight-line code without repeated expressions.

        Raises:
            InputError: llvmlite is not installed.
        """
        if not can_compile():
            raise InputError(
                "machine code needs the package llvmlite, which is not installed: "
                "install it with 'pip install llvmlite', or evaluate with the CasADi virtual machine"
            )
        import llvmlite.binding as llvm

        with _COMPILING:
            _prepare()
            module = llvm.parse_assembly(text)
            module.verify()
            target = llvm.Target.from_default_triple()
            cpu, features = _host()
            machine = target.create_target_machine(cpu=cpu, features=features, opt=level, jit=True)
            self._engine = llvm.create_mcjit_compiler(module, machine)
            self._engine.finalize_object()
            # the engine keeps the code; the parsed module is several times as large
            self._engine.remove_module(module)
            module.close()

    def address(self, symbol: str) -> int:
        """Return the address of a function.

        Args:
            symbol: Its name without the @.

        Raises:
            KeyError: The module does not define it.
        """
        address = int(self._engine.get_function_address(symbol))
        if address == 0:
            raise KeyError(symbol)
        return address


@lru_cache(maxsize=1)
def _host() -> tuple[str, str]:
    import llvmlite.binding as llvm

    return llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()


@lru_cache(maxsize=1)
def _prepare() -> None:
    """Initialise LLVM for the host and register the functions of the mathematical library."""
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    name = ctypes.util.find_library("m") or ctypes.util.find_library("msvcrt")
    library = ctypes.CDLL(name)
    for symbol in sorted(LIBRARY_SYMBOLS):
        address = ctypes.cast(getattr(library, symbol), ctypes.c_void_p).value
        llvm.add_symbol(symbol, address)
