"""The wheel holds all the package needs, and works where the sources are not."""

import os
import subprocess
import sys
import sysconfig
import zipfile
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
SOURCE = ROOT / "src"


@dataclass(frozen=True, kw_only=True)
class Installation:
    """A virtual environment with the wheel in it, and an empty folder to work in."""

    prefix: Path
    work: Path

    @property
    def scripts(self) -> Path:
        return self.prefix / ("Scripts" if os.name == "nt" else "bin")

    def run(self, program: str, *arguments: str) -> str:
        """Run a program of this environment; what it prints."""
        environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
        return run([str(self.scripts / program), *arguments], cwd=self.work, env=environment)


def run(command: list[str], *, cwd: Path, env: dict[str, str] | None = None) -> str:
    done = subprocess.run(
        command,
        cwd=cwd,
        env=env,
        check=False,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        encoding="utf-8",
    )
    assert done.returncode == 0, f"{command} ended with {done.returncode}\n{done.stdout}\n{done.stderr}"
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    options = ["--no-deps", "--no-build-isolation", "--no-index", "--disable-pip-version-check", "--quiet"]
    run([sys.executable, "-m", "pip", "wheel", str(ROOT), *options, "--wheel-dir", str(folder)], cwd=folder)
    (built,) = folder.glob("propermodel-*.whl")
    return built


@pytest.fixture(scope="module")
def installation(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Installation:
    prefix = tmp_path_factory.mktemp("environment")
    clean = Installation(prefix=prefix, work=tmp_path_factory.mktemp("work"))
    run([sys.executable, "-m", "venv", "--without-pip", str(prefix)], cwd=clean.work)

    pip = [sys.executable, "-m", "pip", "--python", str(clean.scripts / "python")]
    options = ["--no-deps", "--no-index", "--disable-pip-version-check", "--quiet"]
    run([*pip, "install", *options, str(wheel)], cwd=clean.work)

    # Lend the dependencies instead of downloading them again. Path files in a lent folder are not read,
    # so the editable installation of the sources stays out of sight.
    (site_packages,) = prefix.glob("[Ll]ib/**/site-packages")
    lent = dict.fromkeys(sysconfig.get_path(scheme) for scheme in ("purelib", "platlib"))
    (site_packages / "lent.pth").write_text("\n".join(lent) + "\n", encoding="utf-8")
    return clean


def test_the_wheel_holds_every_source_and_data_file(wheel: Path):
    skipped = {"__pycache__"}
    expected = {
        path.relative_to(SOURCE).as_posix()
        for path in (SOURCE / "propermodel").rglob("*")
        if path.is_file() and not skipped & set(path.parts) and not path.name.startswith(".")
    }
    with zipfile.ZipFile(wheel) as archive:
        packed = {name for name in archive.namelist() if name.startswith("propermodel/")}
    assert packed == expected
    assert "propermodel/py.typed" in packed


def test_the_wheel_brings_its_licence(wheel: Path):
    with zipfile.ZipFile(wheel) as archive:
        assert any(name.endswith("licenses/LICENSE") for name in archive.namelist())


def test_the_package_is_imported_from_the_clean_environment(installation: Installation):
    printed = installation.run("python", "-c", "import propermodel; print(propermodel.__file__)")
    assert Path(printed.strip()).resolve().is_relative_to(installation.prefix.resolve())


def test_the_command_tells_its_version(installation: Installation):
    assert metadata.version("propermodel") in installation.run("propermodel", "--version")


def test_the_wheel_reduces_the_truck_with_its_own_data(installation: Installation):
    printed = installation.run(
        "propermodel", "reduce", "truck", "--until", "2", "--no-speed", "--no-best-steps", "--out", "study"
    )
    assert "57 energy elements" in printed
    assert (installation.work / "study" / "summary.json").is_file()
