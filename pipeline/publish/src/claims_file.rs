//! `paper/tables/claims.csv`: the claims of the original with the numbers that decide them and the verdicts, tracked beside the other tables, so that
//! they can be read and compared without the PDF.

use std::path::Path;

use crate::paper::{Facts, claim_cells};
use diagnostics::{Diagnostic, Result};
use workflow::runner::write_atomically;

/// The file, in the paper's folder.
const FILE: &str = "tables/claims.csv";
const HEAD: [&str; 5] = ["claim", "says", "published", "ours", "verdict"];

/// Writes every claim, in the order of `claims.toml`.
///
/// # Errors
/// A [`Diagnostic`] when the file cannot be written.
pub(crate) fn write(paper: &Path, facts: &Facts) -> Result<()> {
    let unwritable = |e: &dyn std::fmt::Display| {
        Diagnostic::new(format!("paper/{FILE} cannot be written"), e, "check its permissions and the free disk space")
    };
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(HEAD).map_err(|e| unwritable(&e))?;
    for claim in &facts.claims {
        let cells = claim_cells(claim, facts);
        writer.write_record(std::iter::once(&claim.name).chain(&cells)).map_err(|e| unwritable(&e))?;
    }
    let bytes = writer.into_inner().map_err(|e| unwritable(&e))?;
    write_atomically(&paper.join(FILE), &bytes).map_err(|e| unwritable(&e))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paper::facts_of_tests as facts;

    #[test]
    fn every_claim_has_a_line_with_its_verdict() {
        let folder = std::env::temp_dir().join(format!("claims-{}", std::process::id()));
        std::fs::create_dir_all(folder.join("tables")).unwrap();
        let facts = facts();
        write(&folder, &facts).unwrap();
        let text = std::fs::read_to_string(folder.join(FILE)).unwrap();
        std::fs::remove_dir_all(folder).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "claim,says,published,ours,verdict");
        assert!(lines[1].starts_with("good,it is good,1 mm,") && lines[1].ends_with(",reproduces"), "{}", lines[1]);
        assert!(
            lines[2].starts_with("bad,") && lines[2].ends_with(",does not reproduce") && lines.len() == 3,
            "{}",
            lines[2]
        );
    }
}
