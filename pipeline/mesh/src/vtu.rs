//! VTU: a quadratic mesh as a text file that ParaView and meshio open.

use std::fmt::Write;

use crate::QuadraticMesh;

/// VTK's number for the tetrahedron of ten nodes; its node order equals `fem`'s.
const QUADRATIC_TETRAHEDRON: u8 = 24;

/// The mesh with its regions as cell data.
pub fn write(mesh: &QuadraticMesh) -> String {
    let cells = mesh.tets.len();
    let mut text = String::from("<?xml version=\"1.0\"?>\n");
    text += "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\"><UnstructuredGrid>\n";
    let _ = writeln!(text, "<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{cells}\">", mesh.nodes.len());
    text += "<Points><DataArray type=\"Float64\" Name=\"position_m\" NumberOfComponents=\"3\" format=\"ascii\">\n";
    for [x, y, z] in &mesh.nodes {
        let _ = writeln!(text, "{x:e} {y:e} {z:e}");
    }
    text += "</DataArray></Points>\n<Cells>\n";
    array(&mut text, "Int32", "connectivity", mesh.tets.iter().map(|t| t.map(|n| n.to_string()).join(" ")));
    array(&mut text, "Int32", "offsets", (1..=cells).map(|i| (10 * i).to_string()));
    array(&mut text, "UInt8", "types", (0..cells).map(|_| QUADRATIC_TETRAHEDRON.to_string()));
    text += "</Cells>\n<CellData Scalars=\"region\">\n";
    array(&mut text, "Int32", "region", mesh.regions.iter().map(u16::to_string));
    text + "</CellData>\n</Piece></UnstructuredGrid></VTKFile>\n"
}

fn array(text: &mut String, of: &str, name: &str, rows: impl Iterator<Item = String>) {
    let _ = writeln!(text, "<DataArray type=\"{of}\" Name=\"{name}\" format=\"ascii\">");
    for row in rows {
        text.push_str(&row);
        text.push('\n');
    }
    text.push_str("</DataArray>\n");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_written_mesh_has_its_nodes_elements_and_regions() {
        let nodes = (0..10).map(|i| [f64::from(i), 0.5, -1e-3]).collect();
        let tets = vec![[0, 1, 2, 3, 4, 5, 6, 7, 8, 9], [1, 0, 2, 3, 4, 6, 5, 8, 7, 9]];
        let text = write(&QuadraticMesh { nodes, tets, regions: vec![3, 1], skin: Vec::new(), half: false });
        assert!(text.contains("9e0 5e-1 -1e-3") && text.contains("0 1 2 3 4 5 6 7 8 9\n1 0 2 3 4 6 5 8 7 9\n"));
        assert!(text.contains("Name=\"offsets\" format=\"ascii\">\n10\n20\n<"));
        assert!(text.contains("Name=\"types\" format=\"ascii\">\n24\n24\n<"));
        assert!(text.contains("Name=\"region\" format=\"ascii\">\n3\n1\n<"));
    }
}
