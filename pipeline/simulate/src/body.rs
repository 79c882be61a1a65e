//! The body of a case as a system of `fem`: mesh, materials, clamps, masses and forces, all independent of level and time.

use fem::{Contact, Elements, Faces, Interrupt, Masses, Options, Solver, System};
use mesh::foreign::Region;
use mesh::{Cavity, QuadraticElements, Skin, Solid};
use si::Pascal;

use crate::case::{Case, Chamber, Place};
use crate::clamps::HeldNodes;
use crate::forces::{nodal_forces, nothing_there};
use crate::loads::Loads;
use crate::materials::{case_properties, fast_branches};
use crate::reach::Reach;
use crate::solid::Loaded;
use diagnostics::{Diagnostic, Result};
use mesh::chamber_containing;

/// A case ready to be solved.
pub struct Body<'a> {
    /// The mesh.
    pub solid: &'a Solid,
    /// Its regions.
    pub regions: &'a [Region],
    /// Its closed cavities.
    pub cavities: &'a [Cavity],
    /// The system solved by `fem`.
    pub system: System,
    /// 3 a node, N.
    pub forces: Vec<f64>,
    /// Its clamps.
    pub held: HeldNodes,
    /// The chamber of the mesh that each chamber of the case is.
    pub numbers: Vec<usize>,
    /// Warnings for the user.
    pub notes: Vec<String>,
    interrupt: Option<Interrupt>,
}

impl<'a> Body<'a> {
    /// # Errors
    /// A [`Diagnostic`] when the case and its mesh do not match, or the body is not clamped.
    pub fn new(case: &Case, loaded: &'a Loaded) -> Result<Self> {
        let Loaded { solid, regions, cavities, .. } = loaded;
        let mesh = fem_mesh(solid, &(0..cavities.len() as u16).collect::<Vec<_>>());
        let reach = Reach { solid, size: mesh.size() };
        let (properties, mean_dilatation) = case_properties(case, regions)?;
        let held = HeldNodes::of_case(case, loaded, &reach)?;
        let forces = nodal_forces(case, loaded, &mesh, &held.clamps)?;
        let lumped_mass = case.dynamic.as_ref().is_some_and(|set| set.lumped_mass);
        let contact = case.contact.map(|set| Contact { range: set.range, pressure: set.pressure });
        let options = Options {
            lumped_mass,
            mean_dilatation,
            masses: case_masses(case, &reach, &mesh)?,
            contact,
            ..Options::default()
        };
        let system = System::with(mesh, properties, &held.clamps, options)?;
        let numbers = chamber_numbers(case, solid, cavities)?;
        let mut notes = unnamed_chambers(&numbers, cavities);
        notes.extend(fast_branches(system.regions(), case));
        Ok(Self { solid, regions, cavities, system, forces, held, numbers, notes, interrupt: None })
    }

    /// The same with solvers that ask `interrupt` whether to end.
    pub fn interruptible(self, interrupt: Option<Interrupt>) -> Self {
        Self { interrupt, ..self }
    }

    /// A solver under gravity and all dead loads, with its clamps displaced and its chambers sealed.
    ///
    /// # Errors
    /// A [`Diagnostic`] when `fem` refuses one of them.
    pub fn solver(&self, case: &Case) -> Result<Solver> {
        let mut solver = self.system.solver();
        solver.set_interrupt(self.interrupt.clone());
        solver.set_gravity(case.gravity)?;
        solver.set_forces(&self.forces)?;
        solver.prescribe(&self.held.prescribed)?;
        for (chamber, &number) in
            case.chamber.iter().zip(&self.numbers).filter(|(chamber, _)| chamber.sealed_in.is_some())
        {
            solver.set_sealed(number, chamber.sealed_in)?;
        }
        Ok(solver)
    }

    /// What acts at a level or a time.
    pub fn loads(&self, case: &Case) -> Loads {
        let named = case.chamber.iter().zip(&self.numbers);
        let histories = named.map(|(chamber, &number)| (number, chamber.pressure.clone())).collect();
        Loads {
            forces: self.forces.clone(),
            prescribed: self.held.prescribed.clone(),
            histories,
            chambers: self.cavities.len(),
        }
    }

    /// One pressure a chamber of the mesh, Pa; 0 where the case names none.
    pub fn pressures(&self, case: &Case, value: impl Fn(&Chamber) -> Pascal) -> Vec<Pascal> {
        let mut pressures = vec![0.0; self.cavities.len()];
        for (chamber, &number) in case.chamber.iter().zip(&self.numbers) {
            pressures[number] = value(chamber);
        }
        pressures
    }
}

/// A mesh as the solver takes it: nodes, elements, regions and the faces of each chamber, given by the chambers' skin indices. The one
/// bridge between the mesher's types and the solver's plain arrays.
pub fn fem_mesh(solid: &Solid, chambers: &[u16]) -> fem::Mesh {
    let faces = solid.faces();
    let wall = |skin: &u16| -> Vec<Vec<u32>> {
        faces.iter().filter(|(_, on)| *on == Skin::Chamber(*skin)).map(|(nodes, _)| nodes.to_vec()).collect()
    };
    let walls = chambers.iter().map(wall);
    let elements = fem_elements(solid);
    let of_order = |wall: Vec<Vec<u32>>| match elements {
        Elements::QuadraticHexahedra(_) => {
            Faces::QuadraticQuadrilaterals(wall.iter().map(|nodes| eight_node_side(nodes)).collect())
        }
        Elements::Quadratic(_) => {
            Faces::Quadratic(wall.iter().map(|nodes| std::array::from_fn(|k| nodes[k])).collect())
        }
        _ => Faces::Linear(wall.iter().map(|nodes| std::array::from_fn(|k| nodes[k])).collect()),
    };
    fem::Mesh {
        nodes: solid.nodes().to_vec(),
        regions: solid.regions().to_vec(),
        chambers: walls.map(|wall| fem::Chamber { faces: of_order(wall) }).collect(),
        symmetry_plane_z: solid.half(),
        elements,
    }
}

fn fem_elements(solid: &Solid) -> Elements {
    match solid {
        Solid::Linear(mesh) => Elements::Linear(mesh.tets.clone()),
        Solid::Quadratic(mesh) => match &mesh.elements {
            QuadraticElements::Tetrahedra(tets) => Elements::Quadratic(tets.clone()),
            QuadraticElements::Hexahedra(hexahedra) => Elements::QuadraticHexahedra(hexahedra.clone()),
        },
    }
}

/// A face of hexahedra or wedges as a side of eight nodes.
fn eight_node_side(nodes: &[u32]) -> [u32; 8] {
    match *nodes {
        [a, b, c, ab, bc, ca] => [a, b, c, c, ab, bc, c, ca],
        _ => std::array::from_fn(|k| nodes[k]),
    }
}

fn case_masses(case: &Case, reach: &Reach, mesh: &fem::Mesh) -> Result<Masses> {
    let mut masses = Masses::none();
    for (i, given) in case.mass.iter().enumerate() {
        if let (Some(point), Some(mass)) = (given.near, given.mass) {
            let node = reach.nearest_node(&format!("mass {i}"), point)?;
            masses = match given.hangs {
                Some(axis) => masses.hanging(node, mass, axis as usize),
                None => masses.on_node(node, mass),
            };
        }
        if let (Some(place), Some(layer)) = (Place::of(given.plane, given.block), given.area_density) {
            let faces = reach.faces_in(&place);
            if faces.is_empty() {
                return Err(nothing_there(&format!("mass {i}"), reach));
            }
            masses = faces.iter().try_fold(masses, |sum, face| sum.on_face(mesh, face, layer))?;
        }
    }
    Ok(masses)
}

/// The chamber of the mesh that each chamber of the case is.
fn chamber_numbers(case: &Case, solid: &Solid, cavities: &[Cavity]) -> Result<Vec<usize>> {
    let mut numbers = Vec::new();
    for (i, chamber) in case.chamber.iter().enumerate() {
        let candidate = match (chamber.inside, chamber.number) {
            (Some(point), _) => chamber_containing(solid, point).map(usize::from),
            (None, number) => number.filter(|number| *number < cavities.len()),
        };
        let number = candidate.filter(|number| !numbers.contains(number)).ok_or_else(|| {
            let centres: Vec<String> = cavities.iter().map(|c| format!("{:.4?} m", c.centroid)).collect();
            Diagnostic::new(
                format!("chamber {i} of the case is no chamber of the mesh, or stands twice"),
                format!("the mesh closes {} chambers, with centres {}", cavities.len(), centres.join("; ")),
                "give a point inside one, or its number; a cavity that is open to the outside is no chamber",
            )
        })?;
        numbers.push(number);
    }
    Ok(numbers)
}

fn unnamed_chambers(numbers: &[usize], cavities: &[Cavity]) -> Vec<String> {
    let free = (0..cavities.len()).filter(|number| !numbers.contains(number));
    free.map(|number| format!("chamber {number} of the mesh stays at ambient pressure: the case does not name it"))
        .collect()
}
