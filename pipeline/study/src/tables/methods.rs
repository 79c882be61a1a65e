//! Table `methods`: cost and result of each identification method, beside the published column. Paper, table III.

use optimize::optimisers;
use plot::Column;

use crate::figures::order::capitalised;
use diagnostics::Result;
use records::subject::{Specimen, Study};
use records::{MethodComparison, Search};
use workflow::needs::Every;
use workflow::subject::Subject;
use workflow::table::Table;

/// The table.
pub struct Methods;

/// Iterations, seconds an iteration, minutes in all, loss after four iterations, as the paper prints them.
struct Published([&'static str; 4]);

impl Table for Methods {
    type Of = Study;
    type Needs = Every<MethodComparison, Specimen>;
    const NAME: &'static str = "methods";
    const CAPTION: &'static str = "cost and result of each identification method";
    const VERSION: u32 = 4;

    fn fill(Every(comparisons): Self::Needs) -> Result<plot::Table> {
        let quantities = [("iterations", ""), ("time an iteration", "s"), ("total time", "min"), ("loss after 4", "")];
        let pairs = quantities.iter().flat_map(|(title, unit)| {
            let [ours, published] = Column::beside_published(title, unit);
            // the only quantities with a unit are durations
            [if unit.is_empty() { ours } else { ours.of_durations() }, published]
        });
        let columns = [Column::text("specimen"), Column::text("method")].into_iter().chain(pairs).collect();
        let rows = comparisons
            .iter()
            .flat_map(|(s, comparison)| comparison.searches.iter().map(|search| method_row(&s.name(), search)));
        let table = plot::Table::new(columns, rows.collect())?;
        Ok(table.noted(&cost_note(comparisons.iter().map(|(_, comparison)| comparison))))
    }
}

/// What an iteration is, and in what.
fn cost_note<'a>(comparisons: impl Iterator<Item = &'a MethodComparison>) -> String {
    let whole_body_seconds: Vec<String> =
        comparisons.map(|comparison| format!("{:.0} s", comparison.whole_seconds)).collect();
    format!(
        "An iteration is one simulation of all pressure levels in a reduced model, certified by the whole body, which takes {} of one core. This \
         study: two cores, virtual bench.",
        whole_body_seconds.join(" or ")
    )
}

fn method_row(specimen: &str, search: &Search) -> Vec<String> {
    let each = search.seconds / search.iterations().max(1) as f64;
    let ours = [
        search.iterations().to_string(),
        format!("{each:.1}"),
        format!("{:.2}", search.seconds / 60.0),
        format!("{:.2e}", search.loss_after(5)),
    ];
    let published = published_cost(&search.method).0;
    let pairs = ours.into_iter().zip(published).flat_map(|(a, b)| [a, b.to_string()]);
    [specimen.to_string(), capitalised(optimisers::title_of(&search.method))].into_iter().chain(pairs).collect()
}

/// The paper's table III; empty where it has no such method.
fn published_cost(method: &str) -> Published {
    Published(match method {
        "adam" => ["4", "334.4", "22", "0.0027"],
        "cma_es" => ["40", "321.0", "214", "0.021"],
        "grid" => ["25", "318.9", "132.9", "0.023"],
        _ => [""; 4],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_note_says_how_long_the_whole_body_takes() {
        let on = |whole_seconds| MethodComparison { whole_seconds, ..MethodComparison::default() };
        assert!(cost_note([on(61.2), on(30.0)].iter()).contains("which takes 61 s or 30 s of one core."));
    }
}
