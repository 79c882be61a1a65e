//! DeepLabCut's CSV: three lines of titles (scorer, bodyparts, coords), four with several animals (individuals), then x, y and likelihood of each
//! body part a frame. A part that was not found has empty fields.

use diagnostics::Result;

use super::{Place, import_error, place_at};

/// Least likelihood of an imported position, no unit.
const LIKELIHOOD: f64 = 0.6;

/// A column of three: the animal, where there are several, and the body part.
struct Part {
    individual: String,
    name: String,
}

/// The places of the body parts that `names` are, each with the number of its marker.
pub(super) fn read_places(text: &str, names: &[String]) -> Result<Vec<(usize, Place)>> {
    let mut lines = text.lines().skip(1).filter(|line| !line.trim().is_empty()).peekable();
    let titles = |line: Option<&str>| -> Vec<String> {
        line.unwrap_or_default().split(',').skip(1).map(|word| word.trim().to_owned()).collect()
    };
    let individuals = lines.next_if(|line| line.starts_with("individuals")).map(|line| titles(Some(line)));
    let (parts, coords) = (titles(lines.next()), titles(lines.next()));
    let same_length = individuals.as_ref().is_none_or(|animals| animals.len() == parts.len());
    let has_triples = coords.chunks(3).all(|triple| triple == ["x", "y", "likelihood"]);
    if !(has_triples && same_length && parts.len() == coords.len()) {
        return Err(import_error("its titles do not repeat x, y, likelihood for each body part".into()));
    }
    let part = |k: usize| Part {
        individual: individuals.as_ref().map_or(String::new(), |animals| animals[k].clone()),
        name: parts[k].clone(),
    };
    let parts: Vec<Part> = (0..parts.len()).step_by(3).map(part).collect();
    let columns: Vec<usize> = names.iter().map(|name| part_column(&parts, name)).collect::<Result<_>>()?;
    let mut places = Vec::new();
    let mut last = None;
    for (frame, line) in lines.enumerate() {
        check_order(line, &mut last)?;
        let fields: Vec<&str> = line.split(',').map(str::trim).collect();
        if fields.len() < 1 + 3 * parts.len() {
            return Err(import_error(format!("frame {frame} is short of numbers")));
        }
        for (marker, column) in columns.iter().enumerate() {
            places.push((marker, part_place(frame, [0, 1, 2].map(|k| fields[1 + 3 * column + k]))?));
        }
    }
    Ok(places)
}

/// Frames follow each other where their first field is a number; it may be the name of a picture.
fn check_order(line: &str, last: &mut Option<u64>) -> Result<()> {
    let number = line.split(',').next().and_then(|word| word.trim().parse::<u64>().ok());
    if let (Some(number), Some(previous)) = (number, *last)
        && number != previous + 1
    {
        return Err(import_error(format!("frame {number} stands after frame {previous}")));
    }
    *last = number.or(*last);
    Ok(())
}

/// The column of a marker: the body part of its name, or, of several animals that have it, `animal_part`.
fn part_column(parts: &[Part], name: &str) -> Result<usize> {
    let columns_where =
        |condition: &dyn Fn(&Part) -> bool| (0..parts.len()).filter(|k| condition(&parts[*k])).collect::<Vec<_>>();
    let qualified = columns_where(&|part| {
        [format!("{}_{}", part.individual, part.name), format!("{}-{}", part.individual, part.name)]
            .contains(&name.to_owned())
    });
    let matches = if qualified.is_empty() { columns_where(&|part| part.name == name) } else { qualified };
    if let [only] = matches[..] {
        return Ok(only);
    }
    let part_names: Vec<String> =
        parts.iter().map(|part| format!("{} {}", part.individual, part.name).trim().to_owned()).collect();
    let part_names = part_names.join(", ");
    Err(import_error(match matches.len() {
        0 => format!("no body part is marker `{name}`; the file has {part_names}"),
        count => format!(
            "{count} animals have a body part `{name}`; the file has {part_names}; call the marker animal_part on the card"
        ),
    }))
}

/// A part in a frame; lost where it was not found or its likelihood is low.
fn part_place(frame: usize, [u, v, likelihood]: [&str; 3]) -> Result<Place> {
    let number = |field: &str| match field {
        "" => Ok(f64::NAN),
        field => {
            field.parse::<f64>().map_err(|_| import_error(format!("frame {frame} has `{field}` in place of a number")))
        }
    };
    let (position, likelihood) = ([number(u)?, number(v)?], number(likelihood)?);
    let is_found = likelihood >= LIKELIHOOD && position.iter().all(|x| x.is_finite());
    Ok(Place { at: is_found.then_some(position), ..place_at(position) })
}

#[cfg(test)]
mod tests {
    use diagnostics::Result;

    use super::super::PixelTrack;

    const ONE: &str = "scorer,net,net,net,net,net,net\nbodyparts,m2,m2,m2,m1,m1,m1\ncoords,x,y,likelihood,x,y,likelihood\n0,3,4,0.99,1,2,0.98\n1,3.5,4,0.99,1.5,2,0.97\n";

    fn read_places(text: &str, names: &[String], frames: usize, sigma: f64) -> Result<Vec<PixelTrack>> {
        super::super::read(text.as_bytes(), names, frames, sigma)
    }

    fn names(names: [&str; 2]) -> Vec<String> {
        names.map(str::to_owned).to_vec()
    }

    #[test]
    fn body_parts_are_read_by_their_names() {
        let paths = read_places(ONE, &names(["m1", "m2"]), 2, 0.5).unwrap();
        assert_eq!((paths[0].at[1], paths[1].at[1]), (Some([1.5, 2.0]), Some([3.5, 4.0])));
        assert_eq!(paths[0].covariance[0], [0.25, 0.0, 0.25]);
        let said = read_places(ONE, &names(["m1", "m3"]), 2, 0.5).unwrap_err().why;
        assert!(said.contains("no body part is marker `m3`; the file has m2, m1"), "{said}");
    }

    #[test]
    fn a_part_that_was_not_found_is_lost_in_that_frame() {
        for lost in ["1,3.5,4,0.99,1.5,2,0.30", "1,3.5,4,0.99,,,", "1,3.5,4,0.99,NaN,NaN,1.0", "1,3.5,4,0.99,1.5,2,"] {
            let paths =
                read_places(&ONE.replace("1,3.5,4,0.99,1.5,2,0.97", lost), &names(["m1", "m2"]), 2, 0.5).unwrap();
            assert_eq!([paths[0].at[0], paths[0].at[1]], [Some([1.0, 2.0]), None], "{lost}");
            assert_eq!(paths[1].at[1], Some([3.5, 4.0]));
        }
        assert!(
            read_places(&ONE.replace("3.5,4", "3.5,high"), &names(["m1", "m2"]), 2, 0.5)
                .unwrap_err()
                .why
                .contains("`high`")
        );
    }

    #[test]
    fn of_several_animals_a_part_is_named_with_its_own() {
        let four = "scorer,net,net,net,net,net,net\nindividuals,a,a,a,b,b,b\nbodyparts,tip,tip,tip,tip,tip,tip\ncoords,x,y,likelihood,x,y,likelihood\n0,3,4,0.99,1,2,0.98\n1,,,,1.5,2,0.97\n";
        let paths = read_places(four, &names(["b_tip", "a_tip"]), 2, 0.5).unwrap();
        assert_eq!((paths[0].at[1], paths[1].at[1]), (Some([1.5, 2.0]), None));
        let said = read_places(four, &names(["tip", "a_tip"]), 2, 0.5).unwrap_err().why;
        assert!(said.contains("2 animals have a body part `tip`") && said.contains("a tip, b tip"), "{said}");
        let single = four.replace("tip,tip,tip,tip,tip,tip", "tip,tip,tip,base,base,base");
        assert_eq!(read_places(&single, &names(["base", "tip"]), 2, 0.5).unwrap()[0].at[0], Some([1.0, 2.0]));
    }
}
