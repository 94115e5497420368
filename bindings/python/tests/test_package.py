"""The package itself: names, documentation, types."""
import ast
import inspect
import re
import unittest
from pathlib import Path

import earpoint
from earpoint import _earpoint
from support import SOURCE


def parts_of(module):
    for name in module.__all__:
        thing = getattr(module, name)
        yield name, thing
        if inspect.isclass(thing):
            for member, value in vars(thing).items():
                if not member.startswith("_") and (callable(value) or isinstance(value, (classmethod, property))):
                    yield f"{name}.{member}", getattr(thing, member)


class PackageTest(unittest.TestCase):
    def test_the_version_is_the_projects(self):
        text = (SOURCE / "CMakeLists.txt").read_text()
        self.assertEqual(earpoint.__version__, re.search(r"project\(earpoint VERSION ([\d.]+)", text).group(1))

    def test_the_models_come_along(self):
        shipped = sorted(file.stem for file in (SOURCE / "models").glob("*.safetensors"))
        self.assertGreaterEqual(set(earpoint.models()), set(shipped))
        self.assertIn("gtf", shipped)

    def test_every_public_name_is_documented(self):
        for name, thing in parts_of(earpoint):
            self.assertTrue(inspect.getdoc(thing), name)

    def test_every_parameter_of_a_function_is_documented(self):
        for name in ("render", "trace", "metrics", "locate", "load_weights", "save_weights", "reverberation"):
            function = getattr(earpoint, name)
            for parameter in inspect.signature(function).parameters:
                self.assertIn(f":param {parameter}:", function.__doc__, name)

    def test_the_stub_declares_what_the_module_has(self):
        stub = ast.parse((Path(earpoint.__file__).parent / "_earpoint.pyi").read_text())
        declared = {}
        for node in stub.body:
            if isinstance(node, ast.FunctionDef):
                declared[node.name] = None
            elif isinstance(node, ast.ClassDef):
                declared[node.name] = {part.name for part in node.body if isinstance(part, ast.FunctionDef)}
        there = {name for name in vars(_earpoint) if not name.startswith("__")}
        self.assertEqual(set(declared), there)
        for name, methods in declared.items():
            if methods:
                own = {method for method in vars(getattr(_earpoint, name)) if not method.startswith("__")}
                self.assertEqual({method for method in methods if not method.startswith("__")}, own, name)

    def test_the_package_says_that_it_has_types(self):
        self.assertTrue((Path(earpoint.__file__).parent / "py.typed").is_file())


if __name__ == "__main__":
    unittest.main()
