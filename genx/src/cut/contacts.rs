//! Where faces touch or cross the planes of others: lines along which light ends.

use glam::{DVec3, Vec3};
use scene::Surface;

/// A segment in a face's plane along which another face touches or crosses it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Contact {
    /// Metres.
    pub ends: [DVec3; 2],
    /// The other face.
    pub by: u32,
}

/// The most contacts of a model: 256 MiB.
pub(super) const MOST_CONTACTS: usize = 1 << 22;

/// The contacts of each face, by pairs of faces that are near each other; those along a face's own border are none. An error of
/// one pair where there are more than [`MOST_CONTACTS`].
pub(super) fn contacts(
    surfaces: &[Surface],
    pairs: &[[u32; 2]],
    tolerance: f64,
) -> Result<Vec<Vec<Contact>>, [u32; 2]> {
    let mut contacts = vec![Vec::new(); surfaces.len()];
    let mut count = 0;
    for &[a, b] in pairs {
        for (of, by) in [(a, b), (b, a)] {
            let [face, other] = [of, by].map(|k| &surfaces[k as usize]);
            if let Some(ends) = in_plane_of(face, other, tolerance)
                && enters(face, ends, 2.0 * tolerance)
            {
                contacts[of as usize].push(Contact { ends, by });
                count += 1;
                if count > MOST_CONTACTS {
                    return Err([a, b]);
                }
            }
        }
    }
    Ok(contacts)
}

/// The part of another triangle in the plane of one, if that is a segment.
fn in_plane_of(face: &Surface, other: &Surface, tolerance: f64) -> Option<[DVec3; 2]> {
    let (origin, normal) = (face.corners[0].as_dvec3(), face.normal());
    let corners = other.corners.map(Vec3::as_dvec3);
    let heights = corners.map(|p| {
        let height = (p - origin).dot(normal);
        if height.abs() <= tolerance {
            0.0
        } else {
            height
        }
    });
    let mut points = Vec::with_capacity(3);
    for k in 0..3 {
        let next = (k + 1) % 3;
        let (here, there) = (heights[k], heights[next]);
        if here == 0.0 {
            points.push(corners[k]);
        } else if here * there < 0.0 {
            points.push(corners[k].lerp(corners[next], here / (here - there)));
        }
    }
    match points[..] {
        [from, to] => Some([from, to]),
        _ => None,
    }
}

/// Whether a segment in a triangle's plane has a part inside of it, farther from its sides than a margin.
fn enters(face: &Surface, [from, to]: [DVec3; 2], margin: f64) -> bool {
    let corners = face.corners.map(Vec3::as_dvec3);
    let normal = face.normal();
    let (mut start, mut end) = (0.0_f64, 1.0_f64);
    for k in 0..3 {
        let (p, q) = (corners[k], corners[(k + 1) % 3]);
        let inwards = normal.cross(q - p).normalize_or_zero();
        let height = |point: DVec3| (point - p).dot(inwards) - margin;
        let (at_from, at_to) = (height(from), height(to));
        if at_from <= 0.0 && at_to <= 0.0 {
            return false;
        }
        let crossing = at_from / (at_from - at_to);
        if at_from < 0.0 {
            start = start.max(crossing);
        } else if at_to < 0.0 {
            end = end.min(crossing);
        }
    }
    (end - start) * from.distance(to) > margin
}
