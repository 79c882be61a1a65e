//! Physical groups of gmsh, and the entities of its geometry, which have numbers of their own.
//!
//! Group 2 and volume 2 are two things. While a file is read, an element's tag is its group, or minus its entity's number where the entity is
//! in no group; [`Groups::name_tags`] then says which the file goes by.

use super::raw_mesh::RawMesh;
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// Dimension of surfaces.
pub(super) const SURFACE: usize = 2;
/// Dimension of volumes.
pub(super) const VOLUME: usize = 3;

/// The groups of a file.
#[derive(Debug, Default)]
pub(super) struct Groups {
    /// Of each entity, by its dimension and number.
    of_entity: HashMap<(usize, i64), Vec<i64>>,
    /// The entity that a mesh partition is a part of.
    parents: HashMap<(usize, i64), i64>,
    /// Names of groups, by their dimension and number.
    names: BTreeMap<(usize, i64), String>,
}

impl Groups {
    pub(super) fn set_name(&mut self, dimension: usize, tag: i64, name: String) {
        self.names.insert((dimension, tag), name);
    }

    /// Adds an entity to a group; gmsh writes the number of a group with a minus where the entity is turned around in it.
    pub(super) fn add_entity(&mut self, entity: (usize, i64), group: i64) {
        if group != 0 {
            self.of_entity.entry(entity).or_default().push(group.abs());
        }
    }

    /// Makes an entity the part of another, of the same dimension, in one partition.
    pub(super) fn set_parent(&mut self, entity: (usize, i64), parent: i64) {
        self.parents.insert(entity, parent);
    }

    /// Tags of the elements of an entity.
    pub(super) fn entity_tags(&self, entity: (usize, i64)) -> Vec<i64> {
        let parent = (entity.0, self.parents.get(&entity).copied().unwrap_or(entity.1));
        let groups = self.of_entity.get(&entity).or_else(|| self.of_entity.get(&parent));
        groups.cloned().unwrap_or_else(|| vec![-parent.1])
    }

    /// The tag of an element of version 2.2, which names its group, 0 for none, and its entity.
    pub(super) fn legacy_tag(group: i64, entity: i64) -> i64 {
        if group == 0 { -entity } else { group.abs() }
    }

    /// Names the tags of a mesh that has been read to its end.
    pub(super) fn name_tags(self, raw: &mut RawMesh) {
        raw.names = self.named_tags(VOLUME, "volume", raw.tags.iter_mut());
        raw.surface_names = self.named_tags(SURFACE, "surface", raw.triangles.iter_mut().map(|(_, tag)| tag));
    }

    /// The names of the tags. Where no element is in a group, tags are the numbers of entities, which may then be selected as such; beside
    /// groups, they stay negative. `entity` names them where the file has names, so that none is taken for a group.
    fn named_tags<'a>(
        &self,
        dimension: usize,
        entity: &str,
        tags: impl Iterator<Item = &'a mut i64>,
    ) -> BTreeMap<i64, String> {
        let tags: Vec<&mut i64> = tags.collect();
        let grouped = tags.iter().any(|tag| **tag > 0);
        let mut used = BTreeSet::new();
        for tag in tags {
            *tag = if grouped { *tag } else { -*tag };
            used.insert(*tag);
        }
        let group = |tag: i64| self.names.get(&(dimension, tag)).cloned();
        let has_names = grouped || self.names.keys().any(|(of, _)| *of == dimension);
        let number = |tag: i64| has_names.then(|| format!("{entity} {}", tag.abs()));
        let name = |tag: i64| if grouped && tag > 0 { group(tag) } else { number(tag) };
        used.into_iter().filter_map(|tag| Some((tag, name(tag)?))).collect()
    }
}
