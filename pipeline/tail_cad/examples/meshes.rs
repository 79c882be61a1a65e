//! Size, quality and time of the tail's meshes for several edge lengths.
//!
//! `cargo run --release -p tail_cad --example meshes`

use mesh::{BODY, SPINE, Settings, mesh, quadratic};
use std::time::Instant;
use tail_cad::{Resolution, Tail};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for (name, tail) in [("nine", Tail::nine_chambers()), ("twelve", Tail::twelve_chambers())] {
        for edge in [4e-3, 3e-3, 2.5e-3] {
            let start = Instant::now();
            let own = tail.mesh(&Resolution::even(&tail, edge))?;
            let dofs = 3 * quadratic(&own).nodes.len();
            println!(
                "{name} chambers, own mesh, edge {:.1} mm: {} tets, {dofs} quadratic dofs, body {:.1} mm³, spine {:.1} mm³, chamber {:.1} mm³ (halves), {:.2} s",
                edge * 1e3,
                own.tets.len(),
                own.region_volume(BODY) * 1e9,
                own.region_volume(SPINE) * 1e9,
                own.chamber_volume(0) * 1e9,
                start.elapsed().as_secs_f64()
            );
        }
        let (body, spine) = tail.solids(1.5e-3)?;
        println!("{name} chambers, solids: {} and {} faces", body.faces.len(), spine.faces.len());
        for edge in [4e-3, 3e-3, 2.2e-3] {
            let start = Instant::now();
            match mesh(&body, &spine, &Settings::new(edge)) {
                Ok((made, report)) => println!(
                    "edge {:.1} mm: {} quadratic dofs, {:.2} s\n{report:#?}",
                    edge * 1e3,
                    3 * quadratic(&made).nodes.len(),
                    start.elapsed().as_secs_f64()
                ),
                Err(error) => println!("edge {:.1} mm: {error}", edge * 1e3),
            }
        }
    }
    Ok(())
}
