//! A content-addressed directed acyclic graph (DAG) of typed records: the stages, figures and tables of a paper.
//!
//! A stage reads raw files, its part of a card, its section of the settings and the records of earlier stages, and makes one record for
//! each subject (a project, a group, an item). What it reads is declared as types ([`stage::Stage`], [`needs`]), from which the graph
//! follows: a stage can read nothing that its record is not keyed by. A [`record::Record`] is a set of files with a stable form in
//! bytes; its content is the BLAKE3 of these bytes.
//!
//! **Staleness.** The key of a record is the BLAKE3 of
//! 1. the raw files read,
//! 2. the part of the card read,
//! 3. the section of the settings, as the stage understood it,
//! 4. the content of each record read,
//! 5. the stage's `VERSION`,
//!
//! and of nothing else: no date, no clock and no path. A record is stale when its key differs from that of its present inputs, or when
//! its bytes are not those that were written. Since records are keyed by the content of what they read, a stage that is made again
//! with an equal result leaves all later records up to date (early cutoff).
//!
//! ```
//! use workflow::record::RecordFiles;
//! // the content depends on names and bytes alone: equal files are an equal record, whenever they were made
//! let record = |bytes: &[u8]| RecordFiles::default().file("mesh.bin", bytes.to_vec());
//! assert_eq!(record(b"nodes"), record(b"nodes"));
//! assert_ne!(record(b"nodes"), record(b"elements"));
//! ```
//!
//! [`runner`] plans and makes records in parallel, and alone chooses paths, reads clocks and prints. [`columns`] is the table format of
//! records; [`settings`] reads the settings of a profile; [`stage_graph`] lays out the graph for figures; [`snakemake`]
//! exports it, and [`export`] writes exports of any kind without overwriting what is not theirs.
//!
//! Depends on `diagnostics` and `plot`.

pub mod columns;
pub mod entry;
pub mod export;
pub mod figure;
pub mod metric;
pub mod needs;
pub mod ranges;
pub mod record;
pub mod runner;
pub mod settings;
pub mod shared;
pub mod snakemake;
pub mod stage;
pub mod stage_graph;
pub mod subject;
pub mod table;
#[cfg(test)]
mod testing;
