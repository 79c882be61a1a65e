//! Checks of `[mesh]`: a file alone or surfaces, and what is asked of their meshing.

use lab::range::{Checked, within};
use mesh::{Detail, ElementName, Method};

use super::rule::require;
use super::{Order, Source};

pub(super) fn check_source(mesh: &Source) -> Checked {
    let surfaces = [mesh.body.is_some(), mesh.edge.is_some()];
    let either = surfaces == [mesh.file.is_none(); 2] && (mesh.file.is_none() || mesh.spine.is_none());
    require("mesh", either, "[mesh] has file alone, or body and edge together, and spine where there is one")?;
    let rule = "for surfaces in tetrahedra by the method general or auto alone";
    let tetrahedral = mesh.chosen_elements() == ElementName::Tetrahedra;
    let has_method = mesh.body.is_some() && mesh.method != Method::Columns && tetrahedral;
    require("mesh.detail", mesh.detail.is_usual() || has_method, rule)?;
    let linear = mesh.order == Some(Order::Linear);
    require("mesh.order", !linear || tetrahedral, "hexahedra are quadratic; linear are tetrahedra alone")?;
    let Detail { envelope, smallest, layers } = mesh.detail;
    let lengths = [("mesh.edge", mesh.edge), ("mesh.detail.envelope", envelope), ("mesh.detail.smallest", smallest)];
    lengths.into_iter().try_for_each(|(key, length)| length.map_or(Ok(()), |m| within(key, m, 1e-6..=1.0, "m")))?;
    layers.map_or(Ok(()), |count| within("mesh.detail.layers", f64::from(count), 1.0..=8.0, ""))
}
