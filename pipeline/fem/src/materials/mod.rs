//! The family of materials, by name.
use crate::material::Material;
/// All laws.
pub const ALL: &[&dyn Material] = &[];
/// The law called `name`, as cards write it.
pub fn by_name(name: &str) -> Option<&'static dyn Material> {
    ALL.iter().copied().find(|law| law.name() == name)
}
