# A paper that rebuilds itself. `just` alone lists what there is.

programs := "target/release"
# the coverage counters of libFuzzer, as options of the stable compiler
coverage := "-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table -Cllvm-args=-sanitizer-coverage-trace-compares -Ccodegen-units=1 -Cdebug-assertions"

# list what there is
default:
    @just --list --unsorted

# build the two programs that make everything but the PDF
build:
    cargo build --release --locked

# everything: record the virtual bench, run every stage, draw every figure and table (paper profile)
all: build
    {{programs}}/rig record
    {{programs}}/rig check --write
    {{programs}}/study run
    {{programs}}/study check
    @just paper

# the paper as PDF: from the records at hand, or of the paper profile from what is tracked (the typesetter takes 7 to 13 minutes to build, once)
paper PROFILE="paper": build
    {{programs}}/study paper --profile {{PROFILE}}
    cargo build --release --locked --package typeset
    {{programs}}/typeset --profile {{PROFILE}}

# whether the tracked PDF is the one that the tracked source, tables, figures and numbers give
paper-current: paper
    git ls-files --error-unmatch paper/paper.pdf
    git diff --exit-code --stat -- paper/numbers.csv paper/paper.pdf

# one figure, with what it needs
fig NAME: (recordings NAME)
    {{programs}}/study fig {{NAME}}

# one table, with what it needs
table NAME: (recordings NAME)
    {{programs}}/study table {{NAME}}

# the recordings that a figure, a table or a stage reads: just these trials
recordings NAME: build
    #!/usr/bin/env bash
    set -euo pipefail
    {{programs}}/rig record --cards
    needed=$({{programs}}/study plan {{NAME}} --recordings)
    if [ -n "$needed" ]; then {{programs}}/rig record $needed; fi

# one page to look at, figures/index.html, from the records at hand (of the paper profile: just page paper)
page PROFILE="quick": build
    {{programs}}/study page --profile {{PROFILE}}

# a recorded bar in free vibration: the laws that its recordings support; and an arm of the same silicone, inflated, where its recordings
# are there (they have no public CSV): tables, figures and target/real/metrics.json (study fetch beam_ds10 brings the bar's)
real: build
    {{programs}}/study fit beam_ds10 --out target/real
    cp target/real/real_beam_ds10.svg figures/real_beam.svg
    mkdir -p paper/tables && cp target/real/real_beam_ds10.csv paper/tables/real_beam.csv
    if [ -d data/raw/arm_ds10 ] || [ -d ../shared/real/arm_ds10 ]; then just real-arm; else echo "no recordings of arm_ds10: left out"; fi
    if [ -d data/raw/tensile_ds10 ] || [ -d ../shared/real/tensile_ds10 ]; then just real-joint; else echo "no recordings of tensile_ds10: left out"; fi

# whether stated intervals are honest: specimens drawn at random, recorded and identified in a profile of their own (three minutes of one
# core each), and the share of the true values inside; the table and the figure are those of the paper
calibration COUNT="24" SEED="25": build
    {{programs}}/rig draw {{COUNT}} --seed {{SEED}}
    {{programs}}/study run --profile population calibration coverage
    {{programs}}/study check --profile population
    cp target/population/figures/calibration.svg figures/
    cp target/population/paper/tables/coverage.* paper/tables/

# bar, arm and a strip of the same silicone share a material: what each law predicts of every weight, pressure and test that was left out
real-joint:
    {{programs}}/study fit tensile_ds10 --out target/real
    {{programs}}/study fit ds10 --out target/real
    cp target/real/real_ds10.svg figures/real_scoreboard.svg
    mkdir -p paper/tables && cp target/real/real_ds10.csv paper/tables/real_scoreboard.csv

# the arm alone, with the bar's material in target/real
real-arm:
    {{programs}}/study fit arm_ds10 --out target/real
    cp target/real/real_arm_ds10.svg figures/real_arm.svg
    mkdir -p paper/tables && cp target/real/real_arm_ds10.csv paper/tables/real_arm.csv

# the arm as a specimen without a film, in a project of its own under target/arm: a modulus by `study run` beside that of `study fit`
real-arm-card: build
    #!/usr/bin/env bash
    set -euo pipefail
    page=pipeline/sysid/examples/real/arm_ds10
    for folder in data/raw/arm_ds10 ../shared/real/arm_ds10; do [ -d "$folder" ] && break; done
    if [ ! -d "$folder" ]; then echo "no recordings of arm_ds10: left out"; exit 0; fi
    arm=target/arm/data/raw/arm_ds10
    mkdir -p $arm/cad && cp study.toml target/arm && cp ${page}_card.toml $arm/specimen.toml
    cp "$folder/arm_reconstructed.stl" $arm/cad/body.stl
    # name, pressure (mbar), first and last second of the hold of each recording; its pressure rises in `rise` seconds
    rise=$(awk '$1 == "rise" { print $3 }' $page.toml)
    awk -F'[][=,# ]+' '$1 == "name" { name = $2 } $1 == "pressure" { p = $2 / 100 } $1 == "hold" { gsub("\"", "", name); print name, p, $2, $3 }' $page.toml |
    while read -r name pressure from to; do
        mkdir -p $arm/trials/$name && cp "$folder/v3_$name.csv" $arm/trials/$name/places.csv
        awk -v p=$pressure -v from=$from -v to=$to -v rise=$rise '
            function ramp(t) { return t < 0 ? 0 : t > rise ? 1 : t / rise }
            BEGIN {
                print "# no pressure was logged: the nominal step"
                print "time_s,front_command_mbar,back_command_mbar,left_command_mbar,right_command_mbar,front_mbar,back_mbar,left_mbar,right_mbar"
                for (i = 0; i < 600; i++) {
                    t = i / 100
                    printf "%.2f,%g,0,0,0,%g,0,0,0\n", t, (t >= from - 1e-9 && t < to - 1e-9) * p, p * (ramp(t - from) - ramp(t - to))
                }
            }' > $arm/trials/$name/pressure.csv
    done
    {{programs}}/study doctor arm_ds10 --root target/arm
    {{programs}}/study run --specimen arm_ds10 identify --root target/arm

# a coarse and short version of the main path, of one tail, under target/quick: stages, then every figure and table that they give
quick: build
    {{programs}}/rig record marlin --profile quick
    {{programs}}/study run --profile quick identify method_comparison relaxation validate recovery thrust
    {{programs}}/study run --profile quick --quiet tail overview designs setup sysid dynamics dynamics_water load_cell prototypes trials methods ingredients validation thrust_models optics

# every number against what is expected and published, every claim against its rule (of the paper profile: just check paper)
check PROFILE="quick": build
    {{programs}}/study check --profile {{PROFILE}} --junit target/check-{{PROFILE}}.xml

# a recording and a part of the quick study by Snakemake with two local jobs, and by Slurm where there is one: the recordings of
# `rig record` and the records of `study run` to the byte; odd paths, refused and killed jobs and later specimens (tests/snakemake.py)
snakemake: build
    #!/usr/bin/env bash
    set -euo pipefail
    python=${PYTHON:-python3}
    if ! "$python" -c 'import sys, venv; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then
        echo "no Python 3.11 or later: the workflow for Snakemake is not tested"; exit 0
    fi
    if [ ! -x target/snakemake/bin/snakemake ]; then
        "$python" -m venv target/snakemake
        if ! target/snakemake/bin/pip install --quiet 'snakemake==9.27.0'; then
            rm -rf target/snakemake
            echo "no registry of Python packages: the workflow for Snakemake is not tested"; exit 0
        fi
    fi
    {{programs}}/rig record marlin --profile quick
    root=$PWD/target/workflow-study; base=$root/target/quick
    rm -rf "$root" && mkdir -p "$base" && cp -r study.toml paper "$root"
    snakemake() { target/snakemake/bin/snakemake --quiet all --snakefile "$1/Snakefile" --profile "$1/profiles/$2" "${@:3}"; }
    {{programs}}/rig export snakemake marlin --profile quick --root "$root"
    snakemake "$base/workflow/recording" local --cores 2
    diff --recursive target/quick/data/raw/marlin "$base/data/raw/marlin"
    echo "the recording by snakemake is that of rig record"
    study="$PWD/{{programs}}/study --root $root --profile quick --quiet"
    contents() { (cd "$base/data/processed" && grep --recursive --include=record.json '^  "content"' . | sort); }
    $study run mesh wave
    contents > "$root/by-run" && rm -r "$base/data/processed"
    $study export snakemake --only mesh --only wave
    same() {
        contents > "$root/by-$1"
        cmp "$root/by-run" "$root/by-$1"
        $study plan mesh wave | tail -1 | grep '^0 of'
        echo "$(wc -l < "$root/by-run") records by $1 are those of study run"
    }
    snakemake "$base/workflow" local --cores 2
    same snakemake
    target/snakemake/bin/python tests/snakemake.py
    if ! sinfo --noheader >/dev/null 2>&1; then echo "no Slurm is at hand: its profile is not tested"; exit 0; fi
    target/snakemake/bin/pip install --quiet 'snakemake-executor-plugin-slurm==2.8.0'
    rm -r "$base/data/processed"
    partition=$(sinfo --noheader --format %P | head -1 | tr -d '*')
    snakemake "$base/workflow" slurm --slurm-status-command squeue --seconds-between-status-checks 2 \
        --default-resources "slurm_partition=$partition" slurm_account=none mem_mb=1000
    same slurm

# all tests
test:
    cargo test --release --workspace --exclude typeset --exclude python --locked

# search for inputs that break a reader of files from outside: TARGET is a folder of tests/fuzz/seeds
fuzz TARGET SECONDS="60":
    #!/usr/bin/env bash
    set -euo pipefail
    # with the host named, build scripts and macros are built without the counters
    host=$(rustc -vV | sed -n 's/^host: //p')
    RUSTFLAGS="{{coverage}}" cargo build --release --locked --package fuzz --features engine --target "$host" --target-dir target/fuzz
    mkdir -p target/fuzz/corpus/{{TARGET}}
    FUZZ_TARGET={{TARGET}} "target/fuzz/$host/release/fuzz" target/fuzz/corpus/{{TARGET}} tests/fuzz/seeds/{{TARGET}} \
        -max_total_time={{SECONDS}} -timeout=5 -rss_limit_mb=1024 -artifact_prefix=target/fuzz/{{TARGET}}-

# change CRATE in one place at a time and see whether its tests notice: one mutant in SHARE (cargo install cargo-mutants --locked;
# LEVEL is the crate's optimisation: 0 where building takes longer than its tests, 3 where its tests take longer;
# with TESTS = "--lib --test whole_study" the whole study judges too, some three minutes a mutant)
mutants CRATE SHARE="8" LEVEL="1" TESTS="--tests":
    #!/usr/bin/env bash
    set -euo pipefail
    # a copy of what is tracked, in one place, so that what was compiled for a crate serves the next
    tree=target/mutants/tree
    mkdir -p "$tree"
    find "$tree" -mindepth 1 -maxdepth 1 ! -name target -exec rm -rf {} +
    git ls-files -z -- ':!figures' ':!paper/*.pdf' | xargs -0 tar -cf - | tar -xf - -C "$tree"
    # the last change of an earlier run was compiled later than the crate's files were written. Other crates are safe from it: they
    # use this one at the profile's own level, 2
    find "$tree/pipeline/{{CRATE}}" -name '*.rs' -exec touch {} +
    # what tests alone use (testing.rs) needs no test
    cargo mutants --dir "$tree" --in-place --package {{CRATE}} --exclude '**/testing.rs' --shard 0/{{SHARE}} --sharding round-robin \
        --profile mutants --cargo-arg=--config=profile.mutants.package.{{CRATE}}.opt-level={{LEVEL}} \
        {{ if TESTS == "--tests" { "" } else { "--test-package " + CRATE + " --test-package tests" } }} \
        --output target/mutants/{{CRATE}} -- {{TESTS}}

# what a solve costs, as ratios taken in one run; or one of them: just bench resolution
bench *NAMES="ratios plan resolution":
    cargo bench --workspace --exclude typeset --exclude python --locked {{prepend("--bench ", NAMES)}}

# the same two bodies in softfish, torch-fem and scikit-fem: tip, its derivative, seconds of one core; brings PyTorch (3 GB)
bench-python:
    #!/usr/bin/env bash
    set -euo pipefail
    in=$PWD/target/bench-python/bin
    if [ ! -x "$in/maturin" ]; then
        "${PYTHON:-python3}" -m venv target/bench-python
        # releases, so that two runs compare the same code
        "$in/pip" install --quiet 'torch-fem==0.14.0' 'scikit-fem==12.0.2' meshio 'maturin>=1.9,<2'
    fi
    (cd pipeline/python && rm -rf ../../target/bench-python/wheel &&
        "$in/maturin" build --quiet --release --locked --target-dir ../../target --out ../../target/bench-python/wheel)
    "$in/pip" install --quiet --force-reinstall --no-deps target/bench-python/wheel/softfish-*.whl
    "$in/python" pipeline/python/benches/side_by_side.py

# bodies with chambers meshed by this, gmsh, tetgen and fTetWild: elements, angles, seconds, and the tip of each mesh under pressure
bench-meshers: build
    #!/usr/bin/env bash
    set -euo pipefail
    in=$PWD/target/bench-meshers/bin
    if [ ! -x "$in/python" ]; then
        "${PYTHON:-python3}" -m venv target/bench-meshers
        # releases, so that two runs compare the same code
        "$in/pip" install --quiet 'gmsh==4.15.2' 'tetgen==0.8.4' 'pytetwild==0.4.2' pyvista meshio numpy
    fi
    "$in/python" pipeline/mesh/benches/beside_others.py {{programs}}/study

# formatting and lints, warnings as errors
lint:
    cargo fmt --all --check
    cargo clippy --release --workspace --exclude typeset --exclude python --all-targets --locked -- -D warnings
    RUSTDOCFLAGS="-D warnings" cargo doc --release --no-deps --workspace --exclude typeset --exclude python --locked

# the wheel of the Python package, in target/wheels; needs Python 3.10 or later. It runs where the programs do (.cargo/config.toml)
wheel:
    #!/usr/bin/env bash
    set -euo pipefail
    python3 -m venv target/maturin
    target/maturin/bin/pip install --quiet 'maturin>=1.9,<2'
    cd pipeline/python
    ../../target/maturin/bin/maturin build --release --locked --target-dir ../../target/wheel --out ../../target/wheels

# install the Python package into a fresh virtual environment, and test, type-check and lint it; WITH=torch brings PyTorch, whose
# wheel with its libraries takes 3 GB
test-python WITH="":
    #!/usr/bin/env bash
    set -euo pipefail
    python=${PYTHON:-python3}
    if ! "$python" -c 'import sys, venv; sys.exit(sys.version_info < (3, 10))' 2>/dev/null; then
        echo "no Python 3.10 or later: the package softfish is not tested"; exit 0
    fi
    rm -rf target/python && "$python" -m venv target/python
    in=$PWD/target/python/bin
    if ! "$in/pip" install --quiet 'maturin>=1.9,<2' -r pipeline/python/tests/requirements.txt {{WITH}}; then
        echo "no registry of Python packages: the package softfish is not tested"; exit 0
    fi
    [ -n "{{WITH}}" ] || echo "PyTorch is left out: its tests run with just test-python torch"
    cd pipeline/python
    "$in/maturin" build --quiet --release --locked --target-dir ../../target --out ../../target/python/wheel
    "$in/pip" install --quiet ../../target/python/wheel/softfish-*.whl
    cargo clippy --quiet --release --locked --package python -- -D warnings
    "$in/mypy" --strict softfish
    # away from the sources, so that the wheel is what is imported
    cp -r tests ../../target/python/tests
    cd ../../target/python/tests
    "$in/python" -m mypy.stubtest softfish._core
    SOFTFISH_SOURCE=$OLDPWD "$in/python" -m pytest --quiet -p no:cacheprovider

# what continuous integration runs
ci: test lint test-python quick check

# remove what is made, but neither sources nor tracked figures
clean:
    rm -rf data/processed target/quick
