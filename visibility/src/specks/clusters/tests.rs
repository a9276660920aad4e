//! Clusters hold a scene's regions, and their boxes hold these.

use std::collections::BTreeSet;

use genx::{Model, Settings};
use scene::{Scene, Surface};

use super::*;
use test_scenes::{bumpy_sphere, furnished_sphere, stone};

/// A hall of few and large regions of all kinds, and a scene of small triangles.
fn scenes() -> [Scene; 2] {
    let hall = Settings {
        max_area: Some(100.0),
        ..Settings::new(Model::Hall)
    };
    let hall = genx::make(&hall).unwrap().scene;
    [hall, stone(&furnished_sphere(), f64::INFINITY)]
}

#[test]
fn every_region_is_in_one_cluster_with_its_own_corners() {
    let mut kinds = Vec::new();
    for scene in scenes() {
        let regions = &Regions::new(&scene);
        let clusters = Clusters::new(regions);
        let mut known = BTreeSet::new();
        for cluster in &clusters.all {
            let vertices = clusters.vertices_of(cluster);
            assert_eq!(vertices[0].len() % LANES, 0);
            for place in cluster.places() {
                let id = clusters.regions[place];
                assert!(known.insert(id), "region {id} is there twice");
                let region = &regions.regions()[id as usize];
                assert_eq!(clusters.surfaces[place], region.surfaces[0]);
                let mut corners = Vec::new();
                for piece in region.pieces.clone() {
                    let of_piece = regions.corners(piece as usize);
                    corners.extend(of_piece.iter().map(|&k| regions.vertices()[k as usize]));
                }
                for corner in &corners {
                    let from_middle = (corner.as_dvec3() - cluster.bounds.middle).abs();
                    assert!(from_middle.cmple(cluster.bounds.half).all());
                    assert!(from_middle.length() <= cluster.bounds.radius);
                }
                if cluster.kind == Kind::Triangles {
                    assert!(corners[0].distance(corners[1]) <= cluster.longest);
                }
                if cluster.kind != Kind::Others {
                    let last = corners.len() - 1;
                    for (k, &number) in clusters.corners[place].iter().enumerate() {
                        let vertex = Vec3::from(vertices.map(|axis| axis[usize::from(number)]));
                        assert_eq!(vertex, corners[k.min(last)]);
                    }
                }
            }
        }
        assert_eq!(known.len(), regions.regions().len());
        let mut number = 0;
        for (first, bounds, group) in clusters.groups() {
            assert_eq!(first, number);
            number += group.len() as u32;
            for cluster in group {
                let from_middle = (cluster.bounds.middle - bounds.middle).abs();
                assert!((from_middle + cluster.bounds.half).cmple(bounds.half).all());
            }
        }
        assert_eq!(number as usize, clusters.all.len());
        kinds.extend(clusters.all.iter().map(|cluster| cluster.kind));
    }
    for kind in [Kind::Triangles, Kind::Polygons, Kind::Others] {
        assert!(kinds.contains(&kind), "no {kind:?}");
    }
}

/// Half the diagonal of a square of a cluster's share of the sphere is 0.71 of its side. What is halved across its
/// longest extent is up to twice as long as wide, which makes that 1.12 of it; and where it lies askew its box's
/// diagonal is longer, by sqrt 3 at most.
#[test]
fn clusters_are_small() {
    let scene = stone(&bumpy_sphere(24), f64::INFINITY);
    let clusters = Clusters::new(&Regions::new(&scene));
    let area: f64 = scene.surfaces().iter().map(Surface::area).sum();
    let share = area * REGIONS as f64 / clusters.regions.len() as f64;
    for cluster in &clusters.all {
        assert!(cluster.bounds.radius < 1.95 * share.sqrt(), "{cluster:?}");
    }
}
