"""The wheel in an environment of its own: its modules, its data, and nothing of the source tree."""

import json
import os
import subprocess
import sys
import sysconfig
import venv
import zipfile
from pathlib import Path

import pytest

import dexterity as dx
from dexterity import store

# Run in the wheel's environment: everything that comes with the package is loaded and used.
REPORT = """
import json
import dexterity as dx
from dexterity import store

tools = {}
for name in dx.robots.names():
    chain = dx.robots.build(dx.robots.describe(name))
    q = [0.1 * (i + 1) for i in range(chain.joints)]
    tools[name] = chain.forward(q).tolist()
puma, index = dx.robots.puma560(), dx.indices.Index("manipulability")
ranking = dx.tasks.rank(dx.robots.uvms(), [[0.1] * 12, [0.2] * 12], "welding")
print(json.dumps({
    "file": dx.__file__,
    "in a source tree": store.repository() is not None,
    "version": dx.__version__,
    "tools": tools,
    "tasks": list(dx.tasks.TASKS),
    "values": ranking.values.tolist(),
    "compiled": dx.symbolic.compile_index(puma, index)([0.1] * 6).item(),
    "source": dx.symbolic.c_source(dx.symbolic.derive(puma, index)),
    "networks": {name: dx.networks.load_shipped(name)([0.1] * 12).item() for name in dx.networks.shipped()},
}))
"""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    run_pip("wheel", "--no-deps", "--no-build-isolation", "--wheel-dir", folder, store.repository())
    (built,) = folder.glob("*.whl")
    return built


@pytest.fixture(scope="module")
def environment(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Python of a fresh environment with the wheel; what the package depends on is borrowed from this one.

    Folders that a .pth file names are searched, but .pth files in them are not read: so the editable
    install of the source tree, which is such a file, cannot be seen.
    """
    folder = tmp_path_factory.mktemp("environment")
    venv.create(folder, with_pip=False)
    site_packages = Path(
        sysconfig.get_path("purelib", "venv", {"base": str(folder), "platbase": str(folder)})
    )
    run_pip("install", "--no-deps", "--no-index", "--no-compile", "--target", site_packages, wheel)
    (site_packages / "borrowed.pth").write_text(sysconfig.get_path("purelib") + "\n", encoding="utf-8")
    return (
        Path(sysconfig.get_path("scripts", "venv", {"base": str(folder), "platbase": str(folder)})) / "python"
    )


def run_pip(command: str, *arguments: str | Path) -> None:
    subprocess.run(
        [sys.executable, "-m", "pip", command, "--disable-pip-version-check", "--quiet", *arguments],
        check=True,
        cwd=store.repository(),
    )


def test_the_wheel_holds_package_data_and_licence_only(wheel):
    names = zipfile.ZipFile(wheel).namelist()
    tops = {name.split("/")[0] for name in names}
    assert tops == {"dexterity", f"dexterity_study-{dx.__version__}.dist-info"}
    for name in ("py.typed", "_data/tasks.toml", "_data/robots/uvms.toml"):
        assert f"dexterity/{name}" in names
    assert not [name for name in names if "_data/results" in name or "__pycache__" in name]
    assert {name.split("/")[-1] for name in names if "/licenses/" in name} == {"LICENSE", "NOTICE"}


def test_the_installed_wheel_computes_what_the_source_tree_does(environment, tmp_path):
    variables = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}
    report = json.loads(
        subprocess.run(
            [environment, "-c", REPORT],
            cwd=tmp_path,
            env=variables,
            check=True,
            capture_output=True,
            text=True,
        ).stdout
    )
    assert Path(report["file"]).resolve().is_relative_to(environment.parents[1].resolve())
    assert not report["in a source tree"]
    assert report["version"] == dx.__version__
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
        assert dx.networks.load_shipped(name)([0.1] * 12).item() == value
