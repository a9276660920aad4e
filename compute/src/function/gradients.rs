//! What a function that is linear between vertices misses of a smooth one, as its gradients tell.
//!
//! # Theory
//! A piecewise linear function has one gradient a triangle. Averaged at the vertices, and linear between them, they are nearer
//! to those of the function that it interpolates, and the difference tells what it misses (Zienkiewicz and Zhu, "A simple error estimator
//! and adaptive procedure for practical engineering analysis", International Journal for Numerical Methods in Engineering 24, 1987).
//! Along a side from a to b a function with the gradients g_a and g_b at its ends is, in its middle, off the line between its ends by
//!
//! m = (g_b - g_a) . (b - a) / 8,
//!
//! up to the sign. What is missed within a triangle is then 4 (m_0 l_0 l_1 + m_1 l_1 l_2 + m_2 l_2 l_0), l_k its barycentric
//! coordinates, and the mean of its square
//!
//! 8/45 (m_0^2 + m_1^2 + m_2^2 + m_0 m_1 + m_1 m_2 + m_2 m_0).

use glam::DVec3;
use scene::function::{NodeId, Refinement};

/// Of three channels, a unit of the values per metre.
type Gradient = [DVec3; 3];

/// The gradients of a function that is linear between the vertices of a mesh, averaged at each by area.
pub(super) struct Gradients<'m> {
    mesh: &'m Refinement,
    at_vertices: Vec<Gradient>,
}

impl<'m> Gradients<'m> {
    /// Those of a function with these values at the corners of leaves, in three channels.
    pub fn new(mesh: &'m Refinement, values: impl Fn(NodeId) -> [DVec3; 3]) -> Self {
        let mut sums = vec![([DVec3::ZERO; 3], 0.0); mesh.vertex_count() as usize];
        for leaf in mesh.leaves() {
            let at = mesh.corners(leaf);
            let gradient = of_triangle(at.map(|vertex| mesh.position(vertex)), values(leaf));
            let area = mesh.area(leaf);
            for vertex in at {
                let (sum, weight) = &mut sums[vertex.0 as usize];
                for (sum, gradient) in sum.iter_mut().zip(gradient) {
                    *sum += area * gradient;
                }
                *weight += area;
            }
        }
        let mean =
            |(sum, weight): (Gradient, f64)| sum.map(|sum| sum / weight.max(f64::MIN_POSITIVE));
        Self {
            mesh,
            at_vertices: sums.into_iter().map(mean).collect(),
        }
    }

    /// What is missed in the middles of a leaf's sides, from each corner to the next.
    pub fn missed_of_sides(&self, leaf: NodeId) -> [DVec3; 3] {
        let corners = self.mesh.corners(leaf);
        [0, 1, 2].map(|k| {
            let [a, b] = [corners[k], corners[(k + 1) % 3]];
            let side = self.mesh.position(b) - self.mesh.position(a);
            let [from, to] = [a, b].map(|vertex| &self.at_vertices[vertex.0 as usize]);
            DVec3::from([0, 1, 2].map(|channel| (to[channel] - from[channel]).dot(side) / 8.0))
        })
    }
}

/// The mean over a triangle of the square of what is missed, channel by channel, if this is missed in the middles of its sides.
pub(super) fn mean_square([a, b, c]: [DVec3; 3]) -> DVec3 {
    8.0 / 45.0 * (a * a + b * b + c * c + a * b + b * c + c * a)
}

/// The gradient of what is linear between these values at the corners of a triangle; none where it has no area.
fn of_triangle([a, b, c]: [DVec3; 3], values: [DVec3; 3]) -> Gradient {
    let normal = (b - a).cross(c - a);
    let square = normal.length_squared();
    if square == 0.0 {
        return [DVec3::ZERO; 3];
    }
    // Those of the barycentric coordinates: across the opposite sides.
    let of_corners = [c - b, a - c, b - a].map(|side| normal.cross(side) / square);
    [0, 1, 2].map(|channel| (0..3).map(|k| values[k][channel] * of_corners[k]).sum())
}

#[cfg(test)]
mod tests {
    use scene::Scene;

    use super::*;

    /// A square in two triangles, bisected some times.
    fn square(levels: u32) -> Refinement {
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let corners = corners.map(|[x, y]| glam::Vec3::new(x, y, 0.0));
        let surfaces = test_scenes::quad(corners, 0).to_vec();
        let scene: Scene = test_scenes::scene(vec![test_scenes::material(0.5, 0.0)], surfaces, 9.0);
        let mut mesh = Refinement::new(&scene, |_| true, |_, _| true);
        for _ in 0..levels {
            for leaf in mesh.leaves().collect::<Vec<_>>() {
                mesh.bisect(leaf);
            }
        }
        mesh
    }

    /// What a quadratic function misses is told exactly where gradients are averaged over as much on either side, inside of the mesh:
    /// (x + 2 y)^2 is off the chord of a side s in its middle by (s_x + 2 s_y)^2 / 4.
    #[test]
    fn a_parabola_is_told_exactly() {
        let mesh = square(8);
        let value = |p: DVec3| (p.x + 2.0 * p.y).powi(2);
        let values = |leaf| {
            mesh.corners(leaf)
                .map(|v| DVec3::splat(value(mesh.position(v))))
        };
        let gradients = Gradients::new(&mesh, values);
        let mut inside = 0;
        for leaf in mesh.leaves() {
            let at = mesh.corners(leaf).map(|v| mesh.position(v));
            let is_inside = |p: &DVec3| {
                p.min_element().min(0.0) == 0.0 && (p.x.min(p.y) > 0.2) && p.x.max(p.y) < 0.8
            };
            if !at.iter().all(is_inside) {
                continue;
            }
            inside += 1;
            for (k, missed) in gradients.missed_of_sides(leaf).into_iter().enumerate() {
                let side = at[(k + 1) % 3] - at[k];
                let right = (side.x + 2.0 * side.y).powi(2) / 4.0;
                assert!((missed.x.abs() - right).abs() < 1e-12, "{missed} {right}");
            }
        }
        assert!(inside > 50);
    }

    /// What is linear misses nothing, on the rim of the mesh either.
    #[test]
    fn what_is_linear_misses_nothing() {
        let mesh = square(5);
        let value = |p: DVec3| DVec3::new(p.x, 3.0 - p.y, 2.0);
        let gradients = Gradients::new(&mesh, |leaf| {
            mesh.corners(leaf).map(|v| value(mesh.position(v)))
        });
        for leaf in mesh.leaves() {
            assert!(mean_square(gradients.missed_of_sides(leaf)).max_element() < 1e-24);
        }
    }

    /// The mean of the square over a triangle, by points.
    #[test]
    fn the_mean_square_is_that_of_the_bubbles() {
        let sides = [0.3, -0.2, 0.7].map(|m| DVec3::new(m, 0.0, 0.0));
        let steps = 400;
        let (mut sum, mut count) = (0.0, 0.0);
        for i in 0..steps {
            for j in 0..steps - i {
                let [a, b] = [i, j].map(|k| (f64::from(k) + 1.0 / 3.0) / f64::from(steps));
                let c = 1.0 - a - b;
                let missed = 4.0 * (sides[0].x * a * b + sides[1].x * b * c + sides[2].x * c * a);
                sum += missed * missed;
                count += 1.0;
            }
        }
        let found = mean_square(sides).x;
        assert!(
            (sum / count / found - 1.0).abs() < 0.01,
            "{} {found}",
            sum / count
        );
    }
}
