"""Type stubs: every public name, with the parameters that it has."""

import ast
import inspect
from pathlib import Path

import petzval as pz

STUB = ast.parse((Path(pz.__file__).parent / "__init__.pyi").read_text())


def parameters(arguments):
    """Return the names of the parameters of a function in a stub: ``**settings`` are the keys of their
    class."""
    names = [a.arg for a in (*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs)]
    assert arguments.vararg is None
    if arguments.kwarg is None:
        return names
    unpacked = ast.unparse(arguments.kwarg.annotation)
    assert unpacked.startswith("Unpack["), unpacked
    return names + list(getattr(pz, unpacked[len("Unpack[") : -1]).__annotations__)


def test_every_public_name_has_a_stub_with_its_parameters():
    stubs = {node.name: node for node in STUB.body if hasattr(node, "name")}
    for name in pz.__all__:
        if name == "__version__" or name.endswith("Settings") or inspect.ismodule(getattr(pz, name)):
            # The stub takes modules, and the classes of settings, as they are.
            continue
        assert name in stubs, name
        found, stub = getattr(pz, name), stubs[name]
        if inspect.isclass(found):
            methods = {node.name for node in ast.walk(stub) if hasattr(node, "name")}
            fields = {node.target.id for node in stub.body if isinstance(node, ast.AnnAssign)}
            public = {member for member in vars(found) if not member.startswith("_")}
            assert public <= methods | fields, (name, public - methods - fields)
            members = [
                (getattr(found, node.name), node)
                for node in stub.body
                if isinstance(node, ast.FunctionDef) and not node.decorator_list and "__" not in node.name
            ]
        else:
            members = [(found, stub)]
        for function, node in members:
            own = list(inspect.signature(function).parameters)
            said = parameters(node.args)
            # Methods of the engine hand these on to image_quality; the stub names them.
            handed_on = {"conditions"} & set(own)
            own = [parameter for parameter in own if parameter not in handed_on]
            assert set(own) <= set(said), (name, node.name, own, said)
            assert handed_on or set(said) <= set(own), (name, node.name, own, said)


def test_functions_of_modules_have_types():
    modules = [getattr(pz, name) for name in pz.__all__ if inspect.ismodule(getattr(pz, name))]
    assert modules == [pz.export, pz.measure]
    for module in modules:
        for name in module.__all__:
            signature = inspect.signature(getattr(module, name))
            types = [signature.return_annotation, *(p.annotation for p in signature.parameters.values())]
            assert inspect.Signature.empty not in types, name
