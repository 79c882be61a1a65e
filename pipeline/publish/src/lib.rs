//! From numbers to verdicts, paper, page and archive.
//!
//! [`expected`] compares metrics with expectations, [`claims`] decides the paper's claims, [`check`] prints both, as text or JUnit XML; [`outdated`] finds what is
//! not of the present inputs; [`paper`] resolves the
//! paper's source, [`page`] is one HTML file with everything, [`ro_crate`] describes the records for archives.
//!
//! ```
//! # fn main() -> diagnostics::Result<()> {
//! use publish::expected::Expected;
//! use workflow::{metric::Metric, settings::Profile};
//!
//! let expected = Expected::read(std::path::Path::new("../../paper/expected.toml"), Profile::Quick)?;
//! let ratio = expected.judge(Metric::new("drag.marlin.added_mass_ratio", 2.0, ""));
//! assert_eq!(ratio.status, "drifted");
//! # Ok(())
//! # }
//! ```
//!
//! Depends on `diagnostics`, `plot`, `si`, `workflow`.

pub mod check;
pub mod claims;
mod claims_file;
pub mod expected;
mod junit;
pub mod metrics_file;
mod numbers_file;
pub mod outdated;
pub mod page;
pub mod page_file;
pub mod paper;
pub mod paper_files;
mod real_tables;
mod results_file;
pub mod ro_crate;
mod stage_diagram;
pub mod stand_in;
