//! VTK's legacy files: the ball of `data/` written in each of their forms is the ball of the XML file.

#![allow(clippy::unwrap_used)]

use mesh::foreign::{RawMesh, vtk, vtu};

fn ball() -> RawMesh {
    vtu(&std::fs::read(format!("{}/tests/data/ball_ascii.vtu", env!("CARGO_MANIFEST_DIR"))).unwrap()).unwrap()
}

/// How a file is written.
#[derive(Clone, Copy)]
struct Form {
    binary: bool,
    /// Cells as offsets and connectivity.
    version_5: bool,
}

impl Form {
    fn numbers(self, values: impl Iterator<Item = f64>, kind: &str) -> Vec<u8> {
        let word = |value: f64| match (self.binary, kind) {
            (false, _) => format!("{value:?} ").into_bytes(),
            (true, "double") => value.to_be_bytes().to_vec(),
            (true, "vtktypeint64") => (value as i64).to_be_bytes().to_vec(),
            (true, _) => (value as i32).to_be_bytes().to_vec(),
        };
        let text = |value: f64| if kind == "double" { word(value) } else { format!("{value} ").into_bytes() };
        values.flat_map(|value| if self.binary { word(value) } else { text(value) }).chain([b'\n']).collect()
    }

    fn file(self, mesh: &RawMesh) -> Vec<u8> {
        let cells = mesh.len();
        let each = mesh.each;
        let kind = if self.binary { "BINARY" } else { "ASCII" };
        let head = format!(
            "# vtk DataFile Version 5.1\nthe ball\n{kind}\nDATASET UNSTRUCTURED_GRID\nPOINTS {} double\n",
            mesh.nodes.len()
        );
        let mut file = head.into_bytes();
        file.extend(self.numbers(mesh.nodes.iter().flatten().copied(), "double"));
        let nodes = || mesh.corners.iter().map(|node| f64::from(*node));
        if self.version_5 {
            file.extend(
                format!("METADATA\nINFORMATION 0\n\nCELLS {} {}\nOFFSETS vtktypeint64\n", cells + 1, cells * each)
                    .bytes(),
            );
            file.extend(self.numbers((0..=cells).map(|cell| (cell * each) as f64), "vtktypeint64"));
            file.extend(b"CONNECTIVITY vtktypeint64\n");
            file.extend(self.numbers(nodes(), "vtktypeint64"));
        } else {
            file.extend(format!("CELLS {cells} {}\n", cells * (each + 1)).bytes());
            let nodes: Vec<f64> = nodes().collect();
            let counted =
                nodes.chunks_exact(each).flat_map(|cell| [each as f64].into_iter().chain(cell.iter().copied()));
            file.extend(self.numbers(counted, "int"));
        }
        file.extend(format!("CELL_TYPES {cells}\n").bytes());
        file.extend(self.numbers((0..cells).map(|_| 24.0), "int"));
        file.extend(format!("CELL_DATA {cells}\n").bytes());
        let data = if self.version_5 {
            format!("FIELD FieldData 1\nCellEntityIds 1 {cells} int\n")
        } else {
            "SCALARS CellEntityIds int 1\nLOOKUP_TABLE default\n".to_owned()
        };
        file.extend(data.bytes());
        file.extend(self.numbers(mesh.tags.iter().map(|tag| *tag as f64), "int"));
        file
    }
}

const FORMS: [Form; 4] = [
    Form { binary: false, version_5: false },
    Form { binary: false, version_5: true },
    Form { binary: true, version_5: false },
    Form { binary: true, version_5: true },
];

#[test]
fn every_form_gives_the_ball_of_the_xml_file() {
    let ball = ball();
    for form in FORMS {
        let read = vtk(&form.file(&ball)).unwrap();
        assert_eq!((&read.nodes, &read.corners, &read.tags), (&ball.nodes, &ball.corners, &ball.tags));
    }
}

#[test]
fn a_cut_file_another_dataset_and_a_count_beyond_the_file_are_refused() {
    let ball = ball();
    for form in FORMS {
        let whole = form.file(&ball);
        for part in 1..20 {
            let read = vtk(&whole[..whole.len() * part / 20]).map(|raw| raw.check(1e-3, false));
            assert!(read.is_err() || read.is_ok_and(|checked| checked.is_err()), "{part} twentieths");
        }
    }
    let text = String::from_utf8(FORMS[0].file(&ball)).unwrap();
    let refused = |from: &str, to: &str| vtk(text.replacen(from, to, 1).as_bytes()).unwrap_err().to_string();
    assert!(refused("UNSTRUCTURED_GRID", "POLYDATA").contains("the file holds POLYDATA"));
    assert!(refused("DataFile Version", "Data").contains("does not begin with"));
    assert!(refused("POINTS ", "POINTS 9999999").contains("the number of points is 9999999"));
}
