"""Compilation of the numerical kernels, with a cache that no edit can leave stale.

numba files a compiled function under the place and content of its own module and never looks at the modules it calls.
Each module's kernels therefore lie in a folder named by the digest of the module and of all that it imports, so that
copies of the project share what they have in common.

A function that a kernel calls is part of it: typed and translated once a process, then optimised and turned into
machine code together with its caller, once. numba would do so for each function by itself, and again for all it calls.
"""

from __future__ import annotations

import gc
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, ClassVar, TypeVar, cast

import numba
import numpy as np
from llvmlite import binding
from numba.core import config, typed_passes, types
from numba.core.codegen import CodeLibrary, JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder, Flags
from numba.core.compiler_machinery import PassManager, register_pass
from numba.core.registry import CPUDispatcher
from numpy.typing import NDArray

from pipeline.kernel.code import of_code
from pipeline.kernel.places import cache_root

F = TypeVar("F", bound=Callable[..., Any])
_LOCATORS = f"{__name__}.Folder,UserProvidedCacheLocator,InTreeCacheLocator,UserWideCacheLocator,IPythonCacheLocator"


@cache
def cache_folder(module: str) -> Path:
    """Return the folder of a module's compiled kernels, for the sources as they are now."""
    return cache_root() / "numba" / of_code(module)[:16]


class Folder:
    """Where numba looks for the compiled form of a function of this package, by the content of its sources alone."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self._path = cache_folder(function.__module__)
        self._line = function.__code__.co_firstlineno

    @classmethod
    def from_function(cls, py_func: Callable[..., Any], py_file: str) -> Folder | None:
        """Return the place of a function; none for those of other packages."""
        return cls(py_func) if _ours(py_func) else None

    def ensure_cache_path(self) -> None:
        """Make the folder; raise `OSError` where nothing can be written there."""
        self._path.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=self._path).close()

    def get_cache_path(self) -> str:
        """Return the folder."""
        return str(self._path)

    def get_source_stamp(self) -> str:
        """Return what tells an older form from a newer one: nothing, since they lie in folders of their own."""
        return ""

    def get_disambiguator(self) -> str:
        """Return what tells functions of one name apart."""
        return str(self._line)


def jit(function: F) -> F:
    """Compile `function` without Python objects, IEEE arithmetic kept, the result cached on disk."""
    return _compile(function)


def kernel(function: F) -> F:
    """Compile a function that allocates nothing.

    Without the counting of references, which allocation would need and which costs more than a small kernel's work;
    Python's lock is let go while it runs, so that threads run several at once.
    """
    return _compile(function, _nrt=False, nogil=True)


def inlined(function: F) -> F:
    """Compile like `kernel`, into its callers: for the innermost functions, whose call would cost more than they do."""
    return _compile(function, _nrt=False, forceinline=True)


def new_record(fields: np.dtype[Any], alignment: int = 1) -> Any:
    """Return a record of zeros, the first byte of it on a multiple of `alignment`; its fields are attributes too."""
    room = np.zeros(fields.itemsize + alignment - 1, dtype=np.uint8)
    begin = -room.ctypes.data % alignment if alignment > 1 else 0
    return room[begin : begin + fields.itemsize].view(np.dtype((np.record, fields)))[0]


def by_reference(record: Any) -> NDArray[Any]:
    """Return the array of one that a record stands in: a kernel takes that thirty times as fast as the record."""
    return cast("NDArray[Any]", record.base)


@cache
def by_address(signature: Any, function: Callable[..., None]) -> Any:
    """Compile a function of one signature, to be handed to a kernel: all functions of a signature are of one type."""
    return numba.cfunc(signature, pipeline_class=_WholeCompiler, **_settings(function))(function)


def _compile(function: F, **options: bool) -> F:
    settings = _settings(function)
    keep = settings.pop("cache")
    if config.DISABLE_JIT:  # type: ignore[attr-defined]
        return function
    settings |= {"nopython": True, "boundscheck": None, "no_cfunc_wrapper": True} | options
    made = _Kernel(function, targetoptions=settings, pipeline_class=_WholeCompiler)
    made.part = _Part(function, targetoptions=settings | {"no_cpython_wrapper": True}, pipeline_class=_PartCompiler)
    if keep:
        made.enable_caching()
    return cast(F, made)


class _Kernel(CPUDispatcher):
    """A function as Python calls it; compiled kernels that call it take it as a part of themselves."""

    part: Any

    def compile(self, sig: Any) -> Any:
        """Compile for some types, without the search for garbage, which would take a tenth of the time."""
        searched = gc.isenabled()
        gc.disable()
        try:
            return super().compile(sig)
        finally:
            if searched:
                gc.enable()

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Return what types a call of a compiled kernel; a literal is a number as any, or each were compiled for."""
        numbers = {name: types.unliteral(one) for name, one in kws.items()}
        return self.part.get_call_template(tuple(map(types.unliteral, args)), numbers)

    def get_overload(self, signature: Any) -> Any:
        """Return what a compiled kernel calls."""
        return self.part.get_overload(signature)


class _Part(CPUDispatcher):
    """A function as a compiled kernel calls it: there is nothing of it that Python could call."""

    def add_overload(self, found: Any) -> None:
        """Keep what was compiled for the kernels that ask for it."""
        self.overloads[tuple(found.signature.args)] = found


class _Library(JITCodeLibrary):
    def _optimize_functions(self, ll_module: Any) -> None:
        # Not function by function: they are optimised with all they call, at the end.
        ll_module.data_layout = self._codegen._data_layout


class _PartLibrary(_Library):
    """Code that is only ever part of another: neither optimised nor turned into machine code by itself."""

    def finalize(self) -> None:
        """Leave the code as it is."""
        self._finalized = True

    def own(self) -> Any:
        """Return the code without that of the parts that it calls."""
        return super()._get_module_for_linking()

    def _get_module_for_linking(self) -> Any:
        """Return the code with all that it calls, for kernels that were not compiled here."""
        module = self.own().clone()
        for library in _below(self._linking_libraries):
            module.link_in(_code_of(library), preserve=True)
        return module


class _WholeLibrary(_Library):
    """Code that Python calls, with all its parts: they are optimised and turned into machine code together, once."""

    def finalize(self) -> None:
        """Take in the parts at every depth; then go on as ever."""
        module = self._final_module
        for library in _below(self._linking_libraries):
            self._reload_init.update(library._reload_init)
            module.link_in(_code_of(library), preserve=True)
        self._linking_libraries = []
        super().finalize()

    def _optimize_final_module(self) -> None:
        # Once: what numba runs before it makes counts of references cheaper, of which there are none.
        full, builder = self._codegen._module_pass_manager()
        full.run(self._final_module, builder)

    def serialize_using_object_code(self) -> Any:
        """Return the machine code and which functions are in it; nothing is linked with it, so that IR is not kept."""
        names = [function.name for function in self.get_defined_functions()]
        stubs = "\n".join(f'define void @"{name}"() {{ ret void }}' for name in names)
        return self.name, "object", (self._get_compiled_object(), binding.parse_assembly(stubs).as_bitcode())


def _below(libraries: list[CodeLibrary]) -> list[CodeLibrary]:
    """Return libraries and what parts among them call, at every depth."""
    found: dict[CodeLibrary, None] = {}
    waiting = list(libraries)
    while waiting:
        library = waiting.pop()
        if library not in found:
            found[library] = None
            if isinstance(library, _PartLibrary):
                waiting += library._linking_libraries
    return list(found)


def _code_of(library: Any) -> Any:
    return library.own() if isinstance(library, _PartLibrary) else library._get_module_for_linking()


@register_pass(mutates_CFG=True, analysis_only=False)
class _PartLowering(typed_passes.NativeLowering):
    _name = "part_lowering"

    def run_pass(self, state: Any) -> bool:
        state.library = _PartLibrary(state.targetctx.codegen(), state.func_id.func_qualname)
        state.flags.no_compile = True
        super().run_pass(state)
        # What callers find it by, in place of a function of Python.
        entry = object()
        state.targetctx.insert_user_function(entry, state.cr.fndesc, [state.library])
        state.cr = state.cr._replace(cfunc=entry)
        return True


@register_pass(mutates_CFG=True, analysis_only=False)
class _WholeLowering(typed_passes.NativeLowering):
    _name = "whole_lowering"

    def run_pass(self, state: Any) -> bool:
        state.library = _WholeLibrary(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()
        return bool(super().run_pass(state))


def _passes(state: Any, lowering: type) -> list[PassManager]:
    manager = DefaultPassBuilder.define_nopython_pipeline(state)
    manager.passes = [(lowering if one is typed_passes.NativeLowering else one, of) for one, of in manager.passes]
    manager.finalize()
    return [manager]


class _Flags(Flags):
    """Flags that are told apart quickly: numba does so for every operation whose type it infers."""

    def __hash__(self) -> int:
        return hash((self.nrt, self.forceinline, self.release_gil))

    def __eq__(self, other: object) -> bool:
        return (type(other) is _Flags and self._values == other._values) or super().__eq__(other)


class Types:
    """numba's context of types, which remembers what operators and functions that are not ours make of some types.

    numba would try every form of an operator again for each of its ten thousand uses.
    """

    known: ClassVar[dict[tuple[Any, ...], Any]] = {}

    def __init__(self, context: Any) -> None:
        self._context = context

    def __getattr__(self, name: str) -> Any:
        return getattr(self._context, name)

    def resolve_function_type(self, function: Any, args: Any, kws: Any) -> Any:
        """Return the signature of a call; errors are numba's."""
        if isinstance(function, types.Dispatcher) or kws:
            return self._context.resolve_function_type(function, args, kws)
        key = function, *args
        if key not in self.known:
            self.known[key] = self._context.resolve_function_type(function, args, kws)
        return self.known[key]


class _Compiler(CompilerBase):
    def __init__(self, typingctx: Any, *arguments: Any) -> None:
        super().__init__(typingctx, *arguments)
        self.state.typingctx = Types(typingctx)
        self.state.flags = _Flags(self.state.flags)


class _PartCompiler(_Compiler):
    def define_pipelines(self) -> list[PassManager]:
        return _passes(self.state, _PartLowering)


class _WholeCompiler(_Compiler):
    def define_pipelines(self) -> list[PassManager]:
        return _passes(self.state, _WholeLowering)


def _settings(function: Callable[..., Any]) -> dict[str, Any]:
    # Functions of other places (a notebook, a test) are compiled but not kept.
    keep = _ours(function)
    # numba reads this when a function is decorated.
    config.CACHE_LOCATOR_CLASSES = _LOCATORS  # type: ignore[attr-defined]
    # The nodes of a step stand side by side in memory: four of them are one operation.
    config.SLP_VECTORIZE = 1  # type: ignore[attr-defined]
    return {"cache": keep, "fastmath": False, "error_model": "numpy"}


def _ours(function: Callable[..., Any]) -> bool:
    return function.__module__.split(".")[0] == "pipeline"
