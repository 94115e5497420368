"""Makes the wheel: CMake builds the extension module, the models come along.

From the top of the tree: python3 -m build --no-isolation --wheel --outdir out/python bindings/python
EARPOINT_BUILD_DIR names a build tree that has the module already, which is then taken from there.
"""
import os
import re
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext
from setuptools.command.build_py import build_py
from setuptools.command.sdist import sdist

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
if not (ROOT / "CMakeLists.txt").is_file():
    sys.exit("earpoint: the C++ sources are not there; build in a checkout of the whole project")
VERSION = re.search(r"^project\(earpoint VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text(), re.M).group(1)
# Everything that is made lies outside of the sources.
WORK = ROOT / "build" / "wheel"


class BuildModule(build_ext):
    def build_extension(self, extension):
        given = os.environ.get("EARPOINT_BUILD_DIR")
        tree = Path(given) if given else self.build_tree()
        name = "_earpoint" + sysconfig.get_config_var("EXT_SUFFIX")
        built = tree / "bindings" / "python" / "package" / "earpoint" / name
        if not built.is_file():
            sys.exit(f"earpoint: {built} is not there; configure with -DEARPOINT_PYTHON=ON and build earpoint_python")
        target = Path(self.get_ext_fullpath(extension.name))
        target.parent.mkdir(parents=True, exist_ok=True)
        subprocess.run(["strip", "--strip-unneeded", "-o", target, built], check=True)

    def build_tree(self):
        settings = {"EARPOINT_PYTHON": "ON", "EARPOINT_TRAIN": "OFF", "EARPOINT_BENCH": "OFF", "BUILD_TESTING": "OFF",
                    "EARPOINT_OPENCV": "OFF", "EARPOINT_PYTHON_EXECUTABLE": sys.executable}
        if shutil.which("ccache"):
            settings["CMAKE_CXX_COMPILER_LAUNCHER"] = "ccache"
        environment = {**os.environ, "CCACHE_BASEDIR": str(ROOT), "CCACHE_NOHASHDIR": "1"}
        subprocess.run(["cmake", "--preset", "release", "-B", str(WORK / "cmake"),
                        *(f"-D{key}={value}" for key, value in settings.items())],
                       cwd=ROOT, env=environment, check=True)
        subprocess.run(["cmake", "--build", str(WORK / "cmake"), "--target", "earpoint_python"], env=environment,
                       check=True)
        return WORK / "cmake"


class BuildFiles(build_py):
    """The package's Python files, and the models beside them."""

    def run(self):
        super().run()
        models = Path(self.build_lib) / "earpoint" / "models"
        models.mkdir(parents=True, exist_ok=True)
        for file in sorted((ROOT / "models").iterdir()):
            if file.suffix in (".safetensors", ".md"):
                shutil.copy2(file, models / file.name)
        shutil.copy2(ROOT / "LICENSE", models.parent / "LICENSE")


class NoSources(sdist):
    def run(self):
        sys.exit("earpoint: a source distribution would lack the C++ sources; build with --wheel in a checkout")


WORK.mkdir(parents=True, exist_ok=True)
setup(
    name="earpoint",
    version=VERSION,
    description="Novel-view acoustic synthesis: the sound of a moment from another place",
    long_description=(ROOT / "docs" / "python.md").read_text(),
    long_description_content_type="text/markdown",
    license="Apache-2.0",
    python_requires=">=3.9",
    install_requires=["numpy"],
    extras_require={"torch": ["torch>=1.13"]},
    packages=["earpoint", "earpoint.torch"],
    package_data={"earpoint": ["*.pyi", "py.typed"]},
    ext_modules=[Extension("earpoint._earpoint", sources=[])],
    cmdclass={"build_ext": BuildModule, "build_py": BuildFiles, "sdist": NoSources},
    options={"build": {"build_base": str(WORK / "setuptools")}, "egg_info": {"egg_base": str(WORK)}},
    zip_safe=False,
)
