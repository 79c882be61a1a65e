//! VTU: a quadratic mesh as a text file that ParaView and meshio open.

use std::fmt::Write;

use crate::QuadraticMesh;

/// VTK's numbers of the tetrahedra of four and ten nodes and the hexahedron of twenty, whose node orders equal `fem`'s, and of the wedge of fifteen.
const TETRAHEDRON: u8 = 10;
const QUADRATIC_TETRAHEDRON: u8 = 24;
const QUADRATIC_HEXAHEDRON: u8 = 25;
const QUADRATIC_WEDGE: u8 = 26;
/// The nodes of a wedge among those of a hexahedron, in VTK's order.
const WEDGE: [usize; 15] = [0, 1, 2, 4, 5, 6, 8, 9, 11, 12, 13, 15, 16, 17, 18];

/// VTK's number of a cell with 4, 10 or 20 `nodes`, and its nodes in VTK's order.
pub fn vtk_cell(nodes: &[u32]) -> (u8, Vec<u32>) {
    match nodes.len() {
        4 => (TETRAHEDRON, nodes.to_vec()),
        20 if nodes[2] == nodes[3] => (QUADRATIC_WEDGE, WEDGE.iter().map(|&n| nodes[n]).collect()),
        20 => (QUADRATIC_HEXAHEDRON, nodes.to_vec()),
        _ => (QUADRATIC_TETRAHEDRON, nodes.to_vec()),
    }
}

/// The mesh with its regions as cell data.
pub fn write(mesh: &QuadraticMesh) -> String {
    let listed: Vec<(u8, Vec<u32>)> = mesh.elements.iter().map(vtk_cell).collect();
    let cells = listed.len();
    let mut text = String::from("<?xml version=\"1.0\"?>\n");
    text += "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\"><UnstructuredGrid>\n";
    let _ = writeln!(text, "<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{cells}\">", mesh.nodes.len());
    text += "<Points><DataArray type=\"Float64\" Name=\"position_m\" NumberOfComponents=\"3\" format=\"ascii\">\n";
    for [x, y, z] in &mesh.nodes {
        let _ = writeln!(text, "{x:e} {y:e} {z:e}");
    }
    text += "</DataArray></Points>\n<Cells>\n";
    let words = |nodes: &[u32]| nodes.iter().map(u32::to_string).collect::<Vec<_>>().join(" ");
    write_array(&mut text, "Int32", "connectivity", listed.iter().map(|(_, nodes)| words(nodes)));
    let offsets = listed.iter().scan(0, |sum, (_, nodes)| {
        *sum += nodes.len();
        Some(sum.to_string())
    });
    write_array(&mut text, "Int32", "offsets", offsets);
    write_array(&mut text, "UInt8", "types", listed.iter().map(|(kind, _)| kind.to_string()));
    text += "</Cells>\n<CellData Scalars=\"region\">\n";
    write_array(&mut text, "Int32", "region", mesh.regions.iter().map(u16::to_string));
    text + "</CellData>\n</Piece></UnstructuredGrid></VTKFile>\n"
}

fn write_array(text: &mut String, kind: &str, name: &str, rows: impl Iterator<Item = String>) {
    let _ = writeln!(text, "<DataArray type=\"{kind}\" Name=\"{name}\" format=\"ascii\">");
    for row in rows {
        text.push_str(&row);
        text.push('\n');
    }
    text.push_str("</DataArray>\n");
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::QuadraticElements;

    #[test]
    fn a_written_mesh_has_its_nodes_elements_and_regions() {
        let nodes = (0..10).map(|i| [f64::from(i), 0.5, -1e-3]).collect();
        let tets = vec![[0, 1, 2, 3, 4, 5, 6, 7, 8, 9], [1, 0, 2, 3, 4, 6, 5, 8, 7, 9]];
        let elements = QuadraticElements::Tetrahedra(tets);
        let text = write(&QuadraticMesh { nodes, elements, regions: vec![3, 1], skin: Vec::new(), half: false });
        assert!(text.contains("9e0 5e-1 -1e-3") && text.contains("0 1 2 3 4 5 6 7 8 9\n1 0 2 3 4 6 5 8 7 9\n"));
        assert!(text.contains("Name=\"offsets\" format=\"ascii\">\n10\n20\n<"));
        assert!(text.contains("Name=\"types\" format=\"ascii\">\n24\n24\n<"));
        assert!(text.contains("Name=\"region\" format=\"ascii\">\n3\n1\n<"));
    }
}
