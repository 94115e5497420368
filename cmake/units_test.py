"""Tests of units.py: sources that define the same name do not share a unit."""

import tempfile
import unittest
from pathlib import Path

import units


class UnitsTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def units(self, *texts, most=6):
        """The units of sources of these texts, as lists of their numbers."""
        paths = [self.folder / f"{number}.cpp" for number in range(len(texts))]
        for path, text in zip(paths, texts):
            path.write_text(text)
        return [[int(source.path.stem) for source in unit.sources]
                for unit in units.units_of([units.Source(path) for path in paths], most)]

    def test_sources_of_different_names_share_a_unit(self):
        self.assertEqual(self.units("int f() {\n  return 1;\n}\n", "int g() {\n  return 1;\n}\n"), [[0, 1]])

    def test_names_inside_of_functions_do_not_matter(self):
        self.assertEqual(self.units("int f() {\n  int a = 1;\n}\n", "int g() {\n  int a = 2;\n}\n"), [[0, 1]])

    def test_a_name_of_both_parts_them(self):
        for one in ("constexpr int kSize = 3;", "struct Options {", "enum class Kind {", "double level(int a) {",
                    "std::vector<int> level(\n    int a) {", "const Sound* level(int a) {", "TEST(Sound, Plays) {",
                    "TEST_F(Sound, Plays) {", "#define SIZE 3", "float levels[3] = {};"):
            self.assertEqual(self.units(one + "\n", "int other = 1;\n" + one + "\n"), [[0], [1]], one)

    def test_an_alias_may_be_repeated_but_not_changed(self):
        json, other = "using Json = nlohmann::json;\n", "using Json = nlohmann::ordered_json;\n"
        self.assertEqual(self.units(json, other, json), [[0, 2], [1]])
        self.assertEqual(self.units("using gtf::small;\n", "int small() {\n", "using gtf::small;\n"), [[0, 2], [1]])
        self.assertEqual(self.units("using enum Kind;\n", "using enum Pattern;\n"), [[0], [1]])

    def test_two_programs_do_not_share_a_unit(self):
        self.assertEqual(self.units("BENCHMARK_MAIN();\n", "int main(int argc, char** argv) {\n"), [[0], [1]])

    def test_a_source_that_is_read_for_each_instruction_set_is_alone(self):
        self.assertEqual(self.units("int a;\n", "#include <hwy/foreach_target.h>\n", "int b;\n"), [[0, 2], [1]])

    def test_a_unit_is_not_longer_than_wanted(self):
        self.assertEqual(self.units("int a;\n", "int b;\n", "int c;\n", most=2), [[0, 1], [2]])


if __name__ == "__main__":
    unittest.main()
