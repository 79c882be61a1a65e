//! The entities of the geometry in gmsh's `.msh` of version 4.1, of a whole mesh or of its partitions, and the names of physical groups.

use super::gmsh::File;
use super::raw_mesh::MeshFileError;

impl File<'_> {
    /// Names of groups, which are text in binary files too.
    pub(super) fn read_names(&mut self) -> Result<(), MeshFileError> {
        let count: u64 = self.from.tokens.next_number("the number of names")?;
        for _ in 0..count {
            let dimension: usize = self.from.tokens.next_number("the dimension of a group")?;
            let tag: i64 = self.from.tokens.next_number("the number of a group")?;
            let line = String::from_utf8_lossy(self.from.tokens.rest_of_line()).into_owned();
            self.groups.set_name(dimension, tag, line.trim().trim_matches('"').to_owned());
        }
        Ok(())
    }

    /// Entities, of which only groups and parents are kept.
    pub(super) fn read_entities(&mut self, partitioned: bool) -> Result<(), MeshFileError> {
        self.from.begin_section();
        if partitioned {
            self.read_partitions()?;
        }
        let mut counts = [0; 4];
        for count in &mut counts {
            *count = self.from.read_size("the number of entities")?;
        }
        for (dimension, count) in counts.into_iter().enumerate() {
            for _ in 0..count {
                self.read_entity(dimension, partitioned)?;
            }
        }
        Ok(())
    }

    /// What stands before the entities of partitions: their number, and layers of elements that partitions have from their neighbours.
    fn read_partitions(&mut self) -> Result<(), MeshFileError> {
        self.from.read_size("the number of partitions")?;
        for _ in 0..self.from.read_size("the number of ghost entities")? {
            self.from.read_int("a ghost entity")?;
            self.from.read_int("the partition of a ghost entity")?;
        }
        Ok(())
    }

    fn read_entity(&mut self, dimension: usize, partitioned: bool) -> Result<(), MeshFileError> {
        let entity = (dimension, self.from.read_int("the number of an entity")?);
        if partitioned {
            self.read_parent(entity)?;
        }
        for _ in 0..if dimension == 0 { 3 } else { 6 } {
            self.from.read_real("the bounds of an entity")?;
        }
        for _ in 0..self.from.read_size("the number of groups")? {
            let group = self.from.read_int("a group of an entity")?;
            self.groups.add_entity(entity, group);
        }
        if dimension > 0 {
            for _ in 0..self.from.read_size("the number of bounding entities")? {
                self.from.read_int("a bounding entity")?;
            }
        }
        Ok(())
    }

    fn read_parent(&mut self, entity: (usize, i64)) -> Result<(), MeshFileError> {
        let dimension = self.from.read_int("the dimension of a parent")?;
        let parent = self.from.read_int("the number of a parent")?;
        for _ in 0..self.from.read_size("the number of an entity's partitions")? {
            self.from.read_int("a partition")?;
        }
        // a point or edge between partitions may lie within a surface or volume, whose group it does not have
        if dimension == entity.0 as i64 {
            self.groups.set_parent(entity, parent);
        }
        Ok(())
    }
}
