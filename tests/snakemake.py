"""The exported workflow under the real Snakemake: odd paths, refused and killed jobs, changed settings and a later specimen.

Run by `just snakemake`, from the project's folder, with the interpreter beside which `snakemake` lies and with recordings of `rig record marlin
--profile quick`. Each scenario has a project of its own under target/workflow-faults.
"""

from __future__ import annotations

import ast
import os
import shutil
import subprocess
import sys
from pathlib import Path

PROGRAMS = Path("target/release").resolve()
RECORDING = Path("target/quick/data/raw/marlin").resolve()
FOLDER = Path("target/workflow-faults").resolve()
# what a shell, Python or Snakemake would run, expand or cut, were it not quoted
ODD = ["a b'c", 'd"{x}%s', "$(touch RUN)`touch RUN`;touch RUN", 'e\n\tf";import os;os.system("touch RUN")#', "fäß\\n"]


class Project:
    """A project with recordings, and its exported workflow."""

    def __init__(self, name: str, *only: str) -> None:
        self.root = FOLDER / name
        self.base = self.root / "target/quick"
        self.raw = self.base / "data/raw"
        self.raw.mkdir(parents=True)
        shutil.copy("study.toml", self.root)
        shutil.copytree("paper", self.root / "paper")
        shutil.copytree(RECORDING, self.raw / "marlin")
        self.only = only
        options = [f"--only={stage}" for stage in only]
        assert self.study("export", "snakemake", *options).returncode == 0

    def study(self, *arguments: str) -> subprocess.CompletedProcess[str]:
        command = [PROGRAMS / "study", "--root", self.root, "--profile", "quick", *arguments]
        return subprocess.run(command, capture_output=True, text=True, cwd=FOLDER, check=False)

    def snakemake(self, *options: str) -> subprocess.CompletedProcess[str]:
        folder = self.base / "workflow"
        command = [Path(sys.executable).with_name("snakemake"), "--snakefile", folder / "Snakefile"]
        command += ["--profile", folder / "profiles/local", "--cores", "2", *options]
        return subprocess.run(command, capture_output=True, text=True, cwd=FOLDER, check=False)

    def stale(self) -> int:
        return int(self.study("plan", *self.only).stdout.splitlines()[-1].split()[0])

    def makes(self) -> None:
        """Holds that a run of the workflow succeeds and leaves nothing to be made."""
        run = self.snakemake()
        assert run.returncode == 0 and self.stale() == 0, run.stderr[-2000:]

    def refuses(self) -> None:
        """Holds that a run fails, and a second one as well."""
        for _ in range(2):
            assert self.snakemake().returncode != 0 and self.stale() > 0

    def scheduled(self) -> int:
        """The number of records that a run would make."""
        run = self.snakemake("--dry-run")
        assert run.returncode == 0, run.stderr[-2000:]
        jobs = [line.split() for line in (run.stdout + run.stderr).splitlines()]
        counts = {words[0]: int(words[1]) for words in jobs if len(words) == 2 and words[1].isdigit()}
        return sum(count for rule, count in counts.items() if rule not in ("all", "publish", "total"))

    def replace(self, former: str, present: str) -> None:
        settings = self.root / "study.toml"
        text = settings.read_text()
        assert former in text
        settings.write_text(text.replace(former, present))


def odd_paths_are_not_executed() -> None:
    for name in ODD:
        Project(name, "mesh").makes()
    assert not list(FOLDER.rglob("RUN")), "a text in a path was executed"


def a_recording_that_was_cut_fails_each_run_until_it_is_whole() -> None:
    project = Project("cut", "wave")
    project.makes()
    pressure = project.raw / "marlin/trials/static_left_water/pressure.csv"
    whole = pressure.read_text()
    pressure.write_text("".join(whole.splitlines(keepends=True)[:20]))
    project.refuses()
    pressure.unlink()
    project.refuses()
    pressure.write_text(whole)
    project.makes()


def a_killed_job_is_made_by_the_next_run() -> None:
    project = Project("killed", "clock")
    project.makes()
    project.replace("radius = 18.0 ", "radius = 17.5 ")
    # upstream at the first try, downstream at the second
    for stage in ("track", "clock"):
        killer = project.root / "killer"
        killer.write_text(f'#!/bin/sh\ncase "$*" in *"make {stage}/"*) kill -9 $$;; esac\nexec "{PROGRAMS}/study" "$@"\n')
        killer.chmod(0o755)
        assert project.snakemake("--config", f"study={killer}").returncode != 0
        assert project.stale() > 0
    project.makes()
    assert project.scheduled() == 0


def one_setting_makes_what_the_plan_says_and_a_comment_nothing() -> None:
    project = Project("setting", "clock", "mesh")
    project.makes()
    project.replace("[clock]\n", "[clock]\n# a comment\n")
    assert project.scheduled() == 0
    project.replace("rest_frames = 10", "rest_frames = 11")
    assert project.scheduled() == project.stale() > 0
    project.makes()


def a_specimen_that_came_after_the_export_is_made() -> None:
    project = Project("later", "mesh")
    project.makes()
    later = project.raw / "later"
    shutil.copytree(RECORDING, later)
    card = later / "specimen.toml"
    card.write_text(card.read_text().replace('name = "marlin"', 'name = "later"', 1))
    assert project.scheduled() == project.stale() == 1
    project.makes()
    assert (project.base / "data/processed/mesh/later/record/record.json").is_file()


def a_recording_goes_where_into_says_and_its_path_is_not_executed() -> None:
    """A program in the place of the bench writes down its arguments: a recording takes minutes."""
    for name in ODD:
        root = FOLDER / "recorded" / name
        root.mkdir(parents=True)
        arguments = root / "arguments"
        bench = root / "bench"
        bench.write_text(f'#!{sys.executable}\nimport sys\nopen({str(arguments)!r}, "a").write(repr(sys.argv[1:]) + "\\n")\n')
        bench.chmod(0o755)
        export = [PROGRAMS / "rig", "export", "snakemake", "marlin", "--profile", "quick", "--into", "a b/c"]
        assert subprocess.run(export, cwd=root, check=False).returncode == 0
        folder = root / "a b/c/workflow"
        command = [Path(sys.executable).with_name("snakemake"), "--snakefile", folder / "Snakefile", "--quiet", "all"]
        command += ["--profile", folder / "profiles/local", "--config", f"rig={bench}"]
        subprocess.run(command, cwd=FOLDER, check=True)
        calls = [ast.literal_eval(line) for line in arguments.read_text().splitlines()]
        assert calls and all(call[call.index("--into") + 1] == str(root / "a b/c") for call in calls), calls
    assert not list(FOLDER.rglob("RUN")), "a text in a path was executed"


SCENARIOS = [
    a_recording_goes_where_into_says_and_its_path_is_not_executed,
    odd_paths_are_not_executed,
    a_recording_that_was_cut_fails_each_run_until_it_is_whole,
    a_killed_job_is_made_by_the_next_run,
    one_setting_makes_what_the_plan_says_and_a_comment_nothing,
    a_specimen_that_came_after_the_export_is_made,
]

if __name__ == "__main__":
    shutil.rmtree(FOLDER, ignore_errors=True)
    FOLDER.mkdir(parents=True)
    os.environ.pop("RAYON_NUM_THREADS", None)
    for scenario in SCENARIOS:
        scenario()
        print(f"{scenario.__name__.replace('_', ' ')}: as expected", flush=True)
    shutil.rmtree(FOLDER)
