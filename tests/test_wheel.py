"""The wheel by itself: its files, and what it does with its declared dependencies and nothing else."""

import json
import os
import subprocess
import sys
import sysconfig
import zipfile
from collections.abc import Mapping
from importlib import metadata
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

import dexterity as dx
from dexterity import store
from markdown_blocks import RUNNER, blocks, difference

# Python runs this without site-packages, .pth files and so the editable install of the source tree. The
# site-packages of this environment are borrowed, less what no declared dependency installs.
ISOLATION = """
import sys
from importlib.machinery import PathFinder

class OnlyDeclared(PathFinder):
    @classmethod
    def find_spec(cls, name, path=None, target=None):
        if path is None and name not in ALLOWED:
            path = [folder for folder in sys.path if folder not in BORROWED]
        return super().find_spec(name, path, target)

sys.meta_path[sys.meta_path.index(PathFinder)] = OnlyDeclared
sys.path += [INSTALLED, *BORROWED]
"""

IMPORTS = """
import importlib, json, pkgutil
import dexterity

names = [module.name for module in pkgutil.walk_packages(dexterity.__path__, "dexterity.")]
# The modules of the command need its extra.
names = [name for name in names if not name.startswith("dexterity.command.")]
for name in names:
    importlib.import_module(name)
print(json.dumps({"file": dexterity.__file__, "version": dexterity.__version__, "modules": names}))
"""

REFUSED = """
import importlib, json

refused = []
for name in NAMES:
    try:
        importlib.import_module(name)
    except ModuleNotFoundError:
        refused.append(name)
print(json.dumps(refused))
"""

VALUES = """
import json
import dexterity as dx
from dexterity import store

tools = {}
for name in dx.robots.names():
    chain = dx.robots.build(dx.robots.describe(name))
    q = [0.1 * (i + 1) for i in range(chain.joints)]
    tools[name] = chain.forward(q).tolist()
networks = {name: dx.networks.load_shipped(name) for name in dx.networks.shipped()}
puma, index = dx.robots.puma560(), dx.indices.Index("manipulability")
ranking = dx.tasks.rank(dx.robots.uvms(), [[0.1] * 12, [0.2] * 12], "welding")
shipped = {name: dx.networks.load_shipped(name) for name in dx.networks.shipped()}
print(json.dumps({
    "in a source tree": store.repository() is not None,
    "tools": tools,
    "tasks": list(dx.tasks.TASKS),
    "values": ranking.values.tolist(),
    "compiled": dx.symbolic.compile_index(puma, index)([0.1] * 6).item(),
    "source": dx.symbolic.c_source(dx.symbolic.derive(puma, index)),
    "networks": {name: network([0.1] * network.joints).item() for name, network in shipped.items()},
}))
"""

COST = """
import json, sys, time
import torch

before, start = set(sys.modules), time.process_time()
import dexterity

dexterity.Chain
new = sorted(set(sys.modules) - before)
dexterity.Index, dexterity.robots.load("panda")
print(json.dumps({"seconds": time.process_time() - start, "new": new}))
"""

TABLE = """
from dexterity.timing import Timing, table

table([Timing("way", 1, 1.0, 1.0, 1.0)], "way")
"""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    run_pip("wheel", "--no-deps", "--no-build-isolation", "--wheel-dir", folder, store.repository())
    (built,) = folder.glob("*.whl")
    return built


@pytest.fixture(scope="module")
def installed(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with the wheel and nothing else."""
    folder = tmp_path_factory.mktemp("installed")
    run_pip("install", "--no-deps", "--no-index", "--no-compile", "--target", folder, wheel)
    return folder


@pytest.fixture(scope="module")
def allowed(installed: Path) -> frozenset[str]:
    """Top-level modules of all distributions that the wheel depends on without extras."""
    (own,) = metadata.distributions(path=[str(installed)])
    direct = needed_by(own)
    missing = [name for name in direct if not is_installed(name)]
    assert not missing, "declared dependencies must be in the environment, or the test is blind to them"
    closure, waiting = set(), direct
    while waiting:
        name = waiting.pop()
        # A distribution that another build of torch needs is not there, and so allows nothing.
        if name not in closure and is_installed(name):
            closure.add(name)
            waiting += needed_by(metadata.distribution(name))
    modules = {
        module
        for module, owners in metadata.packages_distributions().items()
        if closure & {canonicalize_name(owner) for owner in owners}
    }
    return frozenset(modules)


def needed_by(distribution: metadata.Distribution) -> list[str]:
    """Return the distributions that one requires here without any extra, by canonical name."""
    requirements = map(Requirement, distribution.requires or ())
    return [
        canonicalize_name(requirement.name)
        for requirement in requirements
        if requirement.marker is None or requirement.marker.evaluate({"extra": ""})
    ]


def is_installed(name: str) -> bool:
    return any(metadata.distributions(name=name))


def run_pip(command: str, *arguments: str | Path) -> None:
    subprocess.run(
        [sys.executable, "-m", "pip", command, "--disable-pip-version-check", "--quiet", *arguments],
        check=True,
        cwd=store.repository(),
    )


class Isolated:
    """Python with the wheel and its declared dependencies alone."""

    def __init__(self, installed: Path, allowed: frozenset[str], folder: Path) -> None:
        borrowed = {sysconfig.get_path("purelib"), sysconfig.get_path("platlib")}
        values = {"ALLOWED": allowed, "INSTALLED": str(installed), "BORROWED": sorted(borrowed)}
        self.header = _assigned(values) + ISOLATION
        self.folder = folder

    def run(self, code: str, **values: object) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [sys.executable, "-I", "-S", "-c", self.header + _assigned(values) + code],
            cwd=self.folder,
            env={name: value for name, value in os.environ.items() if not name.startswith("PYTHON")},
            capture_output=True,
            text=True,
            check=False,
        )

    def output(self, code: str, **values: object) -> str:
        done = self.run(code, **values)
        assert done.returncode == 0, done.stderr
        return done.stdout


def _assigned(values: Mapping[str, object]) -> str:
    return "".join(f"{name} = {value!r}\n" for name, value in values.items())


@pytest.fixture
def isolated(installed: Path, allowed: frozenset[str], tmp_path: Path) -> Isolated:
    return Isolated(installed, allowed, tmp_path)


def test_the_wheel_holds_package_data_and_licence_only(wheel):
    names = zipfile.ZipFile(wheel).namelist()
    tops = {name.split("/")[0] for name in names}
    assert tops == {"dexterity", f"dexterity_study-{dx.__version__}.dist-info"}
    assert {name.split("/")[2] for name in names if name.startswith("dexterity/_data/")} == {
        "networks", "robots", "tasks.toml",
    }  # fmt: skip
    for name in ("py.typed", "scenes/scene.html", "_data/robots/uvms.toml"):
        assert f"dexterity/{name}" in names
    assert not [name for name in names if "__pycache__" in name]
    assert {name.split("/")[-1] for name in names if "/licenses/" in name} == {"LICENSE", "NOTICE"}


def test_what_is_not_declared_cannot_be_imported(isolated):
    undeclared = ["pytest", "pandas", "sklearn", "onnx", "dexterity_study"]
    declared = ["torch", "scipy", "meshcat", "umsgpack"]
    refused = json.loads(isolated.output(REFUSED, NAMES=undeclared + declared))
    assert refused == undeclared


def test_every_module_imports_with_the_declared_dependencies(isolated, installed):
    report = json.loads(isolated.output(IMPORTS))
    assert Path(report["file"]).resolve().is_relative_to(installed.resolve())
    assert report["version"] == dx.__version__
    files = {path.relative_to(installed) for path in installed.glob("dexterity/**/*.py")}
    modules = {".".join(file.with_suffix("").parts).removesuffix(".__init__") for file in files}
    optional = {name for name in modules if name.startswith("dexterity.command.")}
    assert set(report["modules"]) == modules - optional - {"dexterity"}
    assert {f"dexterity.{name}" for name in dx.__all__} - {"dexterity.Chain", "dexterity.Index"} <= modules


def test_each_block_of_the_readme_stands_on_its_own_and_prints_what_it_says(isolated):
    story = [block for block in blocks(store.repository() / "README.md") if block.language == "python"]
    assert len(story) == 5
    results = json.loads(isolated.output(RUNNER, SECTIONS=[[block.code] for block in story]))
    for block, (printed,) in zip(story, results, strict=True):
        assert "import dexterity as dx" in block.code
        assert not (text := difference(block, printed)), text


def test_the_readme_begins_with_the_install_line():
    text = (store.repository() / "README.md").read_text("utf-8")
    assert text.startswith("# dexterity\n\n```bash\npip install ")


def test_the_command_says_what_it_misses(wheel, isolated):
    scripts = (
        zipfile.ZipFile(wheel).read(f"dexterity_study-{dx.__version__}.dist-info/entry_points.txt").decode()
    )
    assert "dexterity = dexterity.command:main" in scripts
    done = isolated.run("import sys; from dexterity.command import main; sys.exit(main(['robots']))")
    assert done.returncode == 3
    assert done.stderr == (
        "dexterity: the command needs typer, which is not installed. "
        "Install it with the extra: pip install 'dexterity-study[command]'\n"
    )


def test_a_missing_extra_is_named(isolated):
    done = isolated.run(TABLE)
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1].startswith("ImportError: tables of timings need pandas: pip install")


def test_the_wheel_computes_what_the_source_tree_does(isolated):
    report = json.loads(isolated.output(VALUES))
    assert not report["in a source tree"]
    assert tuple(report["tools"]) == dx.robots.names()
    for name, tool in report["tools"].items():
        chain = dx.robots.build(dx.robots.describe(name))
        assert chain.forward([0.1 * (i + 1) for i in range(chain.joints)]).tolist() == tool
    assert report["tasks"] == list(dx.tasks.TASKS)
    ranking = dx.tasks.rank(dx.robots.uvms(), [[0.1] * 12, [0.2] * 12], "welding")
    assert report["values"] == ranking.values.tolist()
    puma, index = dx.robots.puma560(), dx.indices.Index("manipulability")
    assert report["compiled"] == dx.symbolic.compile_index(puma, index)([0.1] * 6).item()
    assert report["source"] == dx.symbolic.c_source(dx.symbolic.derive(puma, index))
    assert tuple(report["networks"]) == dx.networks.shipped()
    for name, value in report["networks"].items():
        network = dx.networks.load_shipped(name)
        assert network([0.1] * network.view.joints).item() == value


def test_the_import_is_light(isolated):
    cost = json.loads(isolated.output(COST))
    # Processor seconds beyond torch's own import, which a busy machine does not stretch.
    assert cost["seconds"] <= 1.0
    heavy = {"joblib", "matplotlib", "meshcat", "mpmath", "pandas", "scipy", "sympy"}
    assert not heavy & set(cost["new"])
