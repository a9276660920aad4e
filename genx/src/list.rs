//! The objects and materials of a scene, as a table.

use std::fmt::Write as _;

use scene::{Material, Rgb, Scene, Surface};

/// Triangles and their area, m^2.
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    triangles: usize,
    area: f64,
}

/// Both tables, one line each, by order in the scene: names come last, since they may hold anything.
pub fn of(scene: &Scene) -> String {
    let mut text = String::new();
    // Writing to a string does not fail.
    writeln!(text, "\nobjects, with triangles and area in m^2").ok();
    let sums = sums(scene, scene.objects().len(), |s| s.object.index());
    for (name, Sum { triangles, area }) in scene.objects().iter().zip(sums) {
        writeln!(text, "{triangles:9} {area:12.6e}  {name}").ok();
    }
    writeln!(
        text,
        "\nmaterials, with triangles, area in m^2, reflectance, and emission in W/m^2"
    )
    .ok();
    let sums = self::sums(scene, scene.materials().len(), |s| s.material.index());
    for (material, Sum { triangles, area }) in scene.materials().iter().zip(sums) {
        let Material {
            name,
            reflectance,
            emission,
        } = material;
        let [reflectance, emission] = [reflectance, emission].map(shown);
        writeln!(
            text,
            "{triangles:9} {area:12.6e}  {reflectance:>20}  {emission:>20}  {name}"
        )
        .ok();
    }
    text
}

fn shown(&Rgb { x, y, z }: &Rgb) -> String {
    if x.to_bits() == y.to_bits() && y.to_bits() == z.to_bits() {
        format!("{x}")
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
