//! The objects and materials of a scene, as a table.

use std::collections::HashMap;
use std::fmt::Write as _;

use glam::DVec3;
use scene::{Material, Rgb, Scene, Surface};

use crate::printable::printable;

/// Triangles and their area, m^2.
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    triangles: usize,
    area: f64,
}

/// All materials of one name: with textures there is one for each mean.
struct Named<'s> {
    name: &'s str,
    sum: Sum,
    reflectance: Spread,
    emission: Spread,
}

/// Values of a property, each with an area.
#[derive(Clone, Copy, Debug)]
struct Spread {
    first: Rgb,
    is_one: bool,
    /// Of value times area.
    integral: DVec3,
}

/// Both tables, one line each, by order in the scene: names come last, since they may hold anything.
pub fn of(scene: &Scene) -> String {
    let mut text = String::new();
    // Writing to a string does not fail.
    writeln!(text, "\nobjects, with triangles and area in m^2").ok();
    let objects = sums(scene, scene.objects().len(), |s| s.object.index());
    for (name, Sum { triangles, area }) in scene.objects().iter().zip(objects) {
        let name = printable(name);
        writeln!(text, "{triangles:9} {area:12.6e}  {name}").ok();
    }
    writeln!(
        text,
        "\nmaterials, with triangles, area in m^2, reflectance, and emission in W/m^2; after ~ means by area, where triangles differ"
    )
    .ok();
    for named in by_name(scene) {
        let Sum { triangles, area } = named.sum;
        let [reflectance, emission] = [named.reflectance, named.emission].map(|s| s.shown(area));
        let name = printable(named.name);
        writeln!(
            text,
            "{triangles:9} {area:12.6e}  {reflectance:>20}  {emission:>20}  {name}"
        )
        .ok();
    }
    text
}

/// The materials by name, each where its first one is.
fn by_name(scene: &Scene) -> Vec<Named<'_>> {
    let sums = sums(scene, scene.materials().len(), |s| s.material.index());
    let mut all: Vec<Named> = Vec::new();
    let mut places = HashMap::new();
    for (material, Sum { triangles, area }) in scene.materials().iter().zip(sums) {
        let Material {
            name,
            reflectance,
            emission,
        } = material;
        let place = *places.entry(&name[..]).or_insert(all.len());
        if place == all.len() {
            all.push(Named {
                name,
                sum: Sum::default(),
                reflectance: Spread::new(*reflectance),
                emission: Spread::new(*emission),
            });
        }
        let named = &mut all[place];
        named.sum.triangles += triangles;
        named.sum.area += area;
        named.reflectance.add(*reflectance, area);
        named.emission.add(*emission, area);
    }
    all
}

impl Spread {
    fn new(first: Rgb) -> Self {
        Self {
            first,
            is_one: true,
            integral: DVec3::ZERO,
        }
    }

    fn add(&mut self, value: Rgb, area: f64) {
        self.is_one &= value == self.first;
        self.integral += area * value.as_dvec3();
    }

    /// The value, or the mean of several, to four digits; the first one where no triangle is left to have any.
    fn shown(self, area: f64) -> String {
        if self.is_one || area <= 0.0 {
            let [x, y, z] = self.first.to_array();
            return channels([x, y, z].map(|value| value.to_string()));
        }
        let mean = (self.integral / area).to_array();
        let digits = mean.map(|value| {
            let rounded = format!("{value:.3e}").parse().unwrap_or(value);
            rounded.to_string()
        });
        format!("~{}", channels(digits))
    }
}

/// One number where all are the same.
fn channels([x, y, z]: [String; 3]) -> String {
    if x == y && y == z {
        x
    } else {
        format!("{x},{y},{z}")
    }
}

/// Sums over the surfaces of each of `count` things.
fn sums(scene: &Scene, count: usize, of: impl Fn(&Surface) -> usize) -> Vec<Sum> {
    let mut sums = vec![Sum::default(); count];
    for surface in scene.surfaces() {
        let sum = &mut sums[of(surface)];
        sum.triangles += 1;
        sum.area += surface.area();
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A textured thing that was taken out has materials, but no area to weigh them by.
    #[test]
    fn what_has_no_area_has_a_number_all_the_same() {
        let mut spread = Spread::new(Rgb::splat(0.5));
        spread.add(Rgb::splat(0.5), 0.0);
        spread.add(Rgb::splat(0.25), 0.0);
        assert_eq!(spread.shown(0.0), "0.5");
        spread.add(Rgb::splat(0.25), 2.0);
        assert_eq!(spread.shown(2.0), "~0.25");
    }
}
