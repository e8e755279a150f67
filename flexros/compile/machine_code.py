"""LLVM text to machine code for the processor it runs on, kept in memory and on disk."""

from __future__ import annotations

import ctypes
import ctypes.util
from functools import lru_cache, partial
from importlib.util import find_spec
from threading import Lock
from typing import TYPE_CHECKING, Any

from flexros.compile.object_cache import fingerprint, kept_or_made
from flexros.compile.operations import LIBRARY_SYMBOLS
from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

_PREPARING = Lock()
"""Held for what LLVM keeps for the whole process; threads compile side by side, each in a context of its own."""

_MOST_SHARED = 64
"""Most shared objects that are kept in memory (chosen)."""


class _SharedObject:
    """An object that many modules call; empty until it is made."""

    def __init__(self) -> None:
        self.making, self.content = Lock(), b""


_SHARED: dict[str, _SharedObject] = {}
"""Shared objects by their fingerprints."""


def can_compile() -> bool:
    """Return whether llvmlite is installed."""
    return find_spec("llvmlite") is not None


class MachineCode:
    """Compiled functions. They live as long as this object: keep it together with any address."""

    def __init__(self, texts: Sequence[str], level: int = 1) -> None:
        """Compile LLVM text.

        Args:
            texts: Complete modules: the own one, then those that it calls and shares with others.
            level: Optimisation level of the code generator, 0 to 3. Modules themselves are not optimised: the text is
                already straight-line code without repeated expressions.

        Raises:
            InputError: llvmlite is not installed.
        """
        if not can_compile():
            raise InputError(
                "machine code needs the package llvmlite, which is not installed: "
                "install it with 'pip install llvmlite', or evaluate with the CasADi virtual machine"
            )
        import llvmlite
        import llvmlite.binding as llvm

        with _PREPARING:
            _prepare()
            target = llvm.Target.from_default_triple()
            cpu, features = _host()
            machine = target.create_target_machine(cpu=cpu, features=features, opt=level, jit=True)
        compiler = (llvmlite.__version__, str(llvm.llvm_version_info), target.triple, cpu, features, str(level))
        names = [fingerprint(*compiler, text) for text in texts]
        makes = [partial(_compiled, text, machine) for text in texts]
        objects = [kept_or_made(names[0], makes[0]), *map(_shared_object, names[1:], makes[1:])]
        with _PREPARING:
            self._engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)
            for object_code in objects:
                self._engine.add_object_file(llvm.ObjectFileRef.from_data(object_code))
            self._engine.finalize_object()

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


def _compiled(text: str, machine: Any) -> bytes:
    """Return the object code of a module."""
    import llvmlite.binding as llvm

    module = llvm.parse_assembly(text, context=llvm.create_context())
    module.verify()
    with module:
        return bytes(machine.emit_object(module))


def _shared_object(name: str, make: Callable[[], bytes]) -> bytes:
    """Return an object that many modules call; threads that want the same one wait for the first."""
    with _PREPARING:
        while len(_SHARED) >= _MOST_SHARED and name not in _SHARED:
            _SHARED.pop(next(iter(_SHARED)))
        shared = _SHARED.setdefault(name, _SharedObject())
    with shared.making:
        if not shared.content:
            shared.content = kept_or_made(name, make)
    return shared.content


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
