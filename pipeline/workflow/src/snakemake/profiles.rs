//! Profiles of Snakemake: how jobs are run on one machine, and on a cluster by Slurm.
//!
//! Locks and the repair of half-written records are the store's: a killed workflow is begun again without being unlocked.

/// Their files, from the workflow's folder.
pub(super) const ALL: [(&str, &str); 2] =
    [("profiles/local/config.v8+.yaml", LOCAL), ("profiles/slurm/config.v8+.yaml", SLURM)];

/// All cores of one machine.
const LOCAL: &str = "# snakemake --snakefile workflow/Snakefile --profile workflow/profiles/local
cores: all
# the store has a lock for each record, and knows which record is whole
nolock: true
rerun-incomplete: true
keep-going: true
printshellcmds: false
";

/// Jobs of Slurm. Figures and tables are drawn where Snakemake runs: each takes less time than a job takes to be queued.
const SLURM: &str = "# snakemake --snakefile workflow/Snakefile --profile workflow/profiles/slurm
# needs the package snakemake-executor-plugin-slurm
executor: slurm
jobs: 200
local-cores: 1
nolock: true
rerun-incomplete: true
keep-going: true
# a job that runs out of time or memory is given twice as much
retries: 1
# s: attributes of files on NFS may be that old
latency-wait: 90
# without accounting (slurmdbd), the state of jobs is asked from the queue:
# slurm-status-command: squeue
# default-resources:
#   - slurm_partition=NAME
#   - slurm_account=NAME
";
