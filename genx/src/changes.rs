//! Materials and objects that are given other reflectances, emissions and sides by name.

use std::collections::{BTreeMap, BTreeSet};

use scene::{Material, MaterialId, Rgb, Surface};

/// What a name is given.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    /// Of a material or an object.
    pub name: String,
    /// What it is given.
    pub to: Look,
}

/// What a material or an object can be given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Look {
    /// Reflectance, dimensionless, each channel in [0, 1).
    Reflectance(Rgb),
    /// Exitance, W/m^2, each channel finite and at least 0.
    Emission(Rgb),
    /// Emitted power of all its surfaces together, W, each channel finite and at least 0.
    Power(Rgb),
    /// Its front where its back is.
    Flipped,
    /// Fronts on both sides.
    TwoSided,
}

/// A name that is given something and that nothing has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no material or object is named \"{name}\"; --list tells the names")]
pub struct UnknownName {
    /// The name.
    pub name: String,
}

/// What changes.
pub struct Parts<'a> {
    /// All materials; more of them if an object's has to differ from others'.
    pub materials: &'a mut Vec<Material>,
    /// All objects' names.
    pub objects: &'a [String],
    /// All surfaces.
    pub surfaces: &'a mut Vec<Surface>,
    /// The file's triangle of each, if they come from one.
    pub faces: Option<&'a mut Vec<u32>>,
}

impl Parts<'_> {
    /// Gives names what they are to have, in this order. A name that both a material and an object have is the
    /// material's.
    pub fn change(&mut self, changes: &[Change]) -> Result<(), UnknownName> {
        for change in changes {
            match change.to {
                Look::Flipped => self.flip(&self.surfaces_of(&change.name)?),
                Look::TwoSided => self.back(&self.surfaces_of(&change.name)?),
                Look::Reflectance(_) | Look::Emission(_) | Look::Power(_) => self.paint(change)?,
            }
        }
        Ok(())
    }

    /// Indices of the surfaces of a material or an object.
    pub fn surfaces_of(&self, name: &str) -> Result<Vec<usize>, UnknownName> {
        let of_material = |s: &Surface| self.materials[s.material.index()].name == name;
        let of_object = |s: &Surface| self.objects[s.object.index()] == name;
        let all = |has: &dyn Fn(&Surface) -> bool| -> Vec<usize> {
            let surfaces = self.surfaces.iter().enumerate();
            surfaces.filter(|(_, s)| has(s)).map(|(k, _)| k).collect()
        };
        let found = Some(all(&of_material)).filter(|found| !found.is_empty());
        let found = found.unwrap_or_else(|| all(&of_object));
        if found.is_empty() {
            return Err(UnknownName {
                name: name.to_owned(),
            });
        }
        Ok(found)
    }

    fn flip(&mut self, surfaces: &[usize]) {
        for &k in surfaces {
            self.surfaces[k].corners.swap(1, 2);
        }
    }

    /// Gives surfaces a second one each, on their backs.
    pub fn back(&mut self, surfaces: &[usize]) {
        for &k in surfaces {
            let Surface {
                corners: [a, b, c], ..
            } = self.surfaces[k];
            let corners = [a, c, b];
            self.surfaces.push(Surface {
                corners,
                ..self.surfaces[k]
            });
            if let Some(faces) = &mut self.faces {
                faces.push(faces[k]);
            }
        }
    }

    fn paint(&mut self, change: &Change) -> Result<(), UnknownName> {
        let materials = self.materials_of(&change.name)?;
        let has = |surface: &&Surface| materials.contains(&surface.material);
        let area: f64 = self.surfaces.iter().filter(has).map(Surface::area).sum();
        for id in materials {
            let material = &mut self.materials[id.index()];
            match change.to {
                Look::Reflectance(reflectance) => material.reflectance = reflectance,
                Look::Emission(emission) => material.emission = emission,
                Look::Power(power) => material.emission = (power.as_dvec3() / area).as_vec3(),
                Look::Flipped | Look::TwoSided => {}
            }
        }
        Ok(())
    }

    /// The materials of a name. Those of an object become its own.
    fn materials_of(&mut self, name: &str) -> Result<Vec<MaterialId>, UnknownName> {
        let ids = (0..self.materials.len() as u32).map(MaterialId);
        let named: Vec<MaterialId> = ids
            .filter(|id| self.materials[id.index()].name == name)
            .collect();
        if !named.is_empty() {
            return Ok(named);
        }
        let is_named = |surface: &Surface| self.objects[surface.object.index()] == name;
        let (of_name, others): (Vec<&Surface>, Vec<&Surface>) =
            self.surfaces.iter().partition(|surface| is_named(surface));
        let ids = |surfaces: Vec<&Surface>| -> BTreeSet<u32> {
            surfaces
                .into_iter()
                .map(|surface| surface.material.0)
                .collect()
        };
        let (of_name, others) = (ids(of_name), ids(others));
        if of_name.is_empty() {
            return Err(UnknownName {
                name: name.to_owned(),
            });
        }
        let mut own = BTreeMap::new();
        for before in of_name {
            let after = if others.contains(&before) {
                let material = &self.materials[before as usize];
                self.materials.push(Material {
                    name: format!("{} of {name}", material.name),
                    ..material.clone()
                });
                self.materials.len() as u32 - 1
            } else {
                before
            };
            own.insert(before, after);
        }
        for surface in self.surfaces.iter_mut().filter(|surface| is_named(surface)) {
            surface.material.0 = own[&surface.material.0];
        }
        Ok(own.into_values().map(MaterialId).collect())
    }
}
